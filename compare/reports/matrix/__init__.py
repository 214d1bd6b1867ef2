"""`femic matrix` and `femic export`: the IC matrix on a grid."""
