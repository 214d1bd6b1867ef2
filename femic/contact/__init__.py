"""Exact contact theory on ICs of any source.

Solvers on a grid of elements: `normal` without friction, `frictional` with it, `rolling` for rolling, from
rest or steady, and for compression. They rest on `undeformed` (distances of surfaces), `operators` (ICs),
`friction` (Coulomb's law and motions of surfaces) and `patch` (edges and resultants); `estimates` has the
errors of their results, `exact` closed forms.

`pairs` takes two bodies instead of arrays: grids, C of both, quantities with estimates. `specification` says
what is solved, and `motions` how: one file per motion. `datasets` has their labels, and estimates of
differences between ICs. `finite_elements` does without ICs.

No scene, file or plot. Imports numpy, scipy, xarray, `geometries`, `approx` and `femic.reference`.
"""
