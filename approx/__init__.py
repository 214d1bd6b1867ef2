"""Analytic influence coefficients: the half-space (A), the orientation-based B family and its calibration.

Also line loads on cylinders. Imports numpy, scipy and `geometries`.
"""
