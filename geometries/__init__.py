"""Geometry and materials: contours, materials, bodies, patches, grids and offset lines.

Imports numpy and scipy only, and nothing of this project.
"""
