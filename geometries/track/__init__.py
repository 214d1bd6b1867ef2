"""A wheelset on a track: where wheels touch rails, at which radii and angles, and how they part beside it.

Geometry of the undeformed profiles in the section through the axle. `docs/theory/wheel-on-rail.md` has the
frames and formulas. Imports `geometries` only.
"""
