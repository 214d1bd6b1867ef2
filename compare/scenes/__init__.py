"""Scenes: from a TOML file to bodies, patch and lines."""
