"""Reference influence coefficients (C) by finite elements: meshes, solid engine, discount.

Imports numpy, scipy, scikit-fem, PyAMG, Gmsh, `geometries` and `approx`.
"""
