"""The page system of all reports: pages as data, cells, panels of curves, 3D views, styles of variants.

It knows no question: it imports no other folder of `compare`.
"""
