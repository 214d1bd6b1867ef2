"""Scenes: reads TOML files, checks them, and builds bodies, patch and lines from them.

Imports `femic.contact` and lower layers.
"""
