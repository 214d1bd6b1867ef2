"""Scenes that are small enough to run in a test."""

from tests.compare.conftest import geometry1, small, write_scene

__all__ = ["geometry1", "small", "write_scene"]
