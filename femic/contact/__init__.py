"""Exact contact theory on ICs of any source: operators, undeformed distance, frictionless contact.

Arrays at the seams: no scene, file or plot. Imports numpy, scipy, `geometries` and `approx`.
"""
