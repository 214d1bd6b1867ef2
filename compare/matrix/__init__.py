"""`femic matrix` computes the IC matrix on a grid and writes it."""
