"""Sources of instances: catalogues, the generator, the library."""
