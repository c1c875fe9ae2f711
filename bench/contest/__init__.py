"""What the comparisons with other solvers are made of: a module for each peer, and the table."""
