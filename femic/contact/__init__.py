"""Exact contact theory on ICs of any source.

Solvers on a grid of elements: `normal` without friction, `frictional` with it, `rolling` for rolling, from
rest or steady, and for compression. They rest on `undeformed` (distances of surfaces), `operators` (ICs),
`friction` (Coulomb's law and motions of surfaces) and `patch` (edges and resultants); `estimates` has the
errors of their results, `exact` closed forms.

`pairs` takes two bodies instead of arrays: grids, C of both, all loads, curves, quantities with estimates.
`specification` says what is solved; `motions` is the registry of motions. `finite_elements` does without ICs.

Arrays and plain objects at the seams: no scene, file or plot. Imports numpy, scipy, `geometries`, `approx`
and `femic.reference`.
"""
