"""What others read: connections as tables, and flights as messages and scripts."""
