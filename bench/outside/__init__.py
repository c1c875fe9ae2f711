"""Benchmarks that others made: readers, costs as their texts state them, and scorers.

A folder each. Data are read from a folder that the caller names and are no part of this project.
Scorers share no code with planners; what they share with the model is said in each of them.
"""
