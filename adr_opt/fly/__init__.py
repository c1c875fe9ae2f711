"""Plans in flight: flown, refined, and flown with errors."""
