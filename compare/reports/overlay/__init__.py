"""`femic compare`: results of several scenes together."""
