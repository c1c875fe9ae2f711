"""Where instances come from: catalogues, the generator, the library."""
