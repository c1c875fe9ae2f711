"""Closed tours: all missions of a campaign as one tour through time, at least expense.

Chasers are launched onto any target, one after another, and every target must be done: missions
follow each other in time, so that a campaign is one order of all targets, cut where a mission ends.
Costs are an array by pair, gap and time; nothing here knows whose they are.
"""
