"""The project folder: drafts, dropped files and results, as ordinary files."""
