"""Column generation for several chasers: their routes, and bounds on their total prize."""
