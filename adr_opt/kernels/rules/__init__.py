"""Mission rules and schedules that satisfy them, compiled."""
