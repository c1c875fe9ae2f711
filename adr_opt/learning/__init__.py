"""Environments and what trainers need."""
