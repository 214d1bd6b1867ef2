"""Scenes: TOML files, their checks, and the bodies, patch and lines that they describe.

Imports `femic.contact` and lower layers.
"""
