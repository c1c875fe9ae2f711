"""Refined flights measured: a module for each question."""
