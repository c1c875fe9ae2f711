"""Methods found, prepared and run."""
