"""Bounds without planners. None imports another one."""
