"""Damage of a rolling contact: wear, shakedown and rolling contact fatigue.

`sliding` is what a solved contact in rolling hands over: pressure, traction, slip and speed on elements, with
the work of friction; `t_gamma` splits that work into shares of creepages. `laws` are local wear laws, `wear`
the depths and volumes that follow, `section_loss` wear by T-gamma as a whole, `worn` contacts with the gap
that wear leaves. `shakedown` and `fatigue` are limits and indices from pressures and forces,
`equivalent_stress` is Dang Van's from histories of stresses.

Coefficients are empirical: each has a source, and limits of use, in the docstring of its class, and is a
parameter. Plain arrays at the seams: stresses come from anywhere. Theory: docs/theory/wear-and-fatigue.md.
Imports numpy, scipy, `geometries` and `femic.contact`.
"""
