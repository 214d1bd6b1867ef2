"""Exact contact theory on ICs of any source.

Modules here solve on a grid of elements: `normal` without friction, `frictional` with it, `rolling` (from
rest or steady), `compression`; `operators` are the ICs, `friction` Coulomb's law and motions of surfaces,
`exact` closed forms. `pairs` takes two bodies instead of arrays: grids, C of both, all loads, curves,
quantities with estimates; `motions` is the registry of motions. `finite_elements` does without ICs.

Arrays and plain objects at the seams: no scene, file or plot. Imports numpy, scipy, `geometries`, `approx`
and `femic.reference`.
"""
