"""A learned choice of the next leg, from the connections of one body at one time."""
