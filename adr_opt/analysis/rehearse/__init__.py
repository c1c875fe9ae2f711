"""Rehearsals: missions flown many times in drawn worlds, by policies, and bounds on any policy."""
