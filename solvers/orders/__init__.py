"""Orders of bodies and their best times."""
