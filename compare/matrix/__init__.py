"""`femic matrix` and `femic export` compute the IC matrix on a grid and write it."""
