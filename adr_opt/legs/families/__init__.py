"""The families of legs."""
