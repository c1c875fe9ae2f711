"""Dynamic programming by sets of targets, where arrivals are functions of time.

Who leaves later arrives no earlier, so that of all ways to have done a set of targets and to be at
one of them the earliest is enough: Held and Karp (1962) with time in place of length.
"""
