"""Closed-form contact solutions, to compare numerical ones with: Hertz, the pin in a hole."""
