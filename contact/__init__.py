"""Exact contact theory on ICs of any source: so far the IC matrix as an operator.

Imports numpy, scipy and `geometries`; `compare` imports it.
"""
