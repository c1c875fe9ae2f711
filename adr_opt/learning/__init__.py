"""Environments and support for trainers."""
