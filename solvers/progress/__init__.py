"""What every method keeps track of: incumbent, gap, time."""
