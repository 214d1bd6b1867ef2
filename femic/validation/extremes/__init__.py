"""`femic extremes` tries each part at its limits: its errors there, and its messages beyond them."""
