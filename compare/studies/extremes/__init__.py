"""`femic extremes`: how far each part goes, how wrong it is there, and what it says beyond."""
