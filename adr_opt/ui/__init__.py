"""User interfaces: the command line, pages, plots and cards."""
