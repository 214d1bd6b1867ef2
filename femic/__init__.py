"""Reference influence coefficients (C) by finite elements: meshes, both engines, discount, matrices.

Imports numpy, scipy, scikit-fem, PyAMG, joblib, threadpoolctl, xarray, fsspec, `geometries` and `approx`. One
module each imports Gmsh, meshio and, where it is installed, pypardiso, and only when it needs it.
"""
