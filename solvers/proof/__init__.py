"""Proofs of optimality."""
