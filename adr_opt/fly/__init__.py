"""Plans flown, refined, and flown with errors."""
