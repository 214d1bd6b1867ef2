"""Computes the contact of a scene's bodies with several ICs, and writes it."""
