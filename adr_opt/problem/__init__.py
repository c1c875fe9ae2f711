"""The problem: instances and their parts."""
