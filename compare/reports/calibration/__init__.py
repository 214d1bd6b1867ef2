"""`femic calibrate` and `femic calibrate-map` fit B-hat-prime to C."""
