"""Exact contact theory on ICs of any source: so far the IC matrix as an operator.

Imports numpy, scipy, `geometries`, `approx` and `femic`; `compare` imports it.
"""
