"""What is there: contours, materials, bodies, patches and offset lines.

Imports numpy and scipy only, and nothing of this project.
"""
