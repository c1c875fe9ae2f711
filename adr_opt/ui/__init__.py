"""What people see: the command line, pages, plots and cards."""
