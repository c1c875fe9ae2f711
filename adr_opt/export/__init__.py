"""Exports for other programs: connections as tables, flights as messages and scripts."""
