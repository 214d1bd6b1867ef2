"""`femic judge`: contact by finite elements without ICs, and contacts with ICs beside it."""
