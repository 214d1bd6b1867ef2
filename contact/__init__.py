"""Exact contact theory on ICs from anywhere: so far the matrix as an operator.

Imports numpy, scipy, `geometries`, `approx` and `femic`; `compare` imports it.
"""
