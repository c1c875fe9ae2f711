"""Methods: look-up, preparation and runs."""
