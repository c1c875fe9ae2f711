"""What all rooms use: errors, files, records, cards, constants, stopping, progress."""
