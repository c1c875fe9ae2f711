"""Legs between two bodies, compiled."""
