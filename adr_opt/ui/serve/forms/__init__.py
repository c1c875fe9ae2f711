"""Fields of the forms that edit parts of an instance."""
