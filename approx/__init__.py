"""Analytic influence coefficients: the half-space (A) and the orientation-based B family.

Imports numpy and `geometries`.
"""
