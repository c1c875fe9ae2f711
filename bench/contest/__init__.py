"""Comparisons with other solvers: a module for each peer, and the table."""
