"""Networks of connections that proofs search."""
