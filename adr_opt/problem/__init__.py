"""What is asked: instances and their parts."""
