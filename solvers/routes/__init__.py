"""Routes of several chasers: pools, set packing, target exchange."""
