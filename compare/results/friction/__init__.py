"""Computes the contact with friction of a scene's bodies, rolling or pressed together, and writes it."""
