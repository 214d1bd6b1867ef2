"""`femic calibrate` and `calibrate-map`: B-hat-prime fitted to C."""
