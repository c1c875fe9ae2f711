"""Closed forms of legs compared: a module for each kind."""
