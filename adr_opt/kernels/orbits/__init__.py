"""Orbits and motion, compiled."""
