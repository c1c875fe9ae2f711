"""Routes of several chasers: pooled, packed, exchanged."""
