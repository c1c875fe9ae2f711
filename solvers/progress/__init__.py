"""Progress of a method: incumbent, gap and time."""
