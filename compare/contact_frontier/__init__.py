"""`femic frontier` and `femic advise` of contacts: errors over seconds, by ICs and grids."""
