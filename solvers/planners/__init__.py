"""Planners: a module or a folder each. None imports another one."""
