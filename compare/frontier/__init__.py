"""`femic frontier` and `femic advise` compare the speed and the accuracy of ways to compute ICs."""
