"""Orders of bodies and their optimal timing."""
