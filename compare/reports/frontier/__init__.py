"""`femic frontier` and `femic advise`: speed against accuracy."""
