"""Fields of forms: those that edit parts of an instance, and options of verbs."""
