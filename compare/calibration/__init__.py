"""`femic calibrate` fits B-hat-prime to C."""
