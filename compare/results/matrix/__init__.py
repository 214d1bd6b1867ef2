"""Computes the IC matrix of a scene, checks it, and writes it strip by strip."""
