"""`femic stresses`: stresses under the contact of a scene in the bodies, wear and fatigue numbers.

`contacts` solves one contact with each of the ICs, `lattice` has the points below it, `compute` the
stresses there, `damage` the numbers of wear and fatigue; `dataset` labels all of these. `answers`, `figures`
and `page` draw them.
"""
