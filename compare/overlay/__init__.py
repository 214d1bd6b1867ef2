"""`femic compare` shows the results of several scenes together."""
