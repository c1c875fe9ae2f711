"""The report: made from the rows alone, so that it can be made again at any time."""
