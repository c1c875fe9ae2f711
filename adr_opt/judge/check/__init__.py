"""Whether a plan keeps to every rule."""
