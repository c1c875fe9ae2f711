"""Jobs: verbs of the command line, run in processes of their own on the files of the project."""
