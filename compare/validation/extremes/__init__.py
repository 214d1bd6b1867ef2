"""`femic extremes` runs each part at its limits: errors there, and messages beyond them."""
