"""Networks of connections for proofs."""
