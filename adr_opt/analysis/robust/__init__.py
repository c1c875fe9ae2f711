"""Robust plans: tanks and departures hold with a required probability."""
