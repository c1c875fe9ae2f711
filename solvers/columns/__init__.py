"""Several chasers: searches over their routes, and bounds on what they collect together."""
