"""The solid engine: a body as a 3D mesh of quadratic tetrahedra, multigrid or direct."""
