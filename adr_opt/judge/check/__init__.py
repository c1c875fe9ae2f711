"""Checks of a plan against every rule."""
