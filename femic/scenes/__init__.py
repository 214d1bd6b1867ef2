"""Scenes: reads TOML files, checks them, and builds bodies, patch and lines from them.

Imports nothing else of `compare`.
"""
