"""Episodes of the environment, compiled."""
