"""Objects of dropped files: recognised, listed in columns, and made into a mission."""
