"""The rules of a mission and schedules that keep to them, compiled."""
