"""Contact of two bodies: their grids, their ICs, quantities with their estimates.

It joins the solvers of `femic.contact`, which know arrays on a grid only, with the geometry of bodies. It
knows no scenes, no files and no figures.
"""
