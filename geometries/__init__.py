"""Geometry and materials: contours, surfaces, materials, bodies, patches, grids, offset lines, quadrature.

Imports numpy and scipy only, and nothing of this project.
"""
