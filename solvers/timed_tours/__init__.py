"""Tours by sets of targets, and bounds on routes, where arrivals are functions of time.

Who leaves later arrives no earlier, so that of all ways to have done a set of targets and to be at
one of them the earliest is enough: Held and Karp (1962) with time in place of length. And who
counts as ready earlier than in truth loses nothing, so that a few departures bound all.
"""
