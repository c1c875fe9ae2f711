"""What is asked of an import, by the options of a command line or the fields of a form."""
