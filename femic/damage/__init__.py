"""Damage of a rolling contact: wear, shakedown and rolling contact fatigue.

`laws` begins with what a solved contact in rolling hands over: pressure, traction, slip and speed on
elements, with the work of friction; worn depths follow by local laws. `wear` are contacts with the gap that
wear leaves. `fatigue` has limits and indices from pressures and forces: the shakedown map, T-gamma by shares
of creepages, surface fatigue. `dang_van` is the equivalent stress from histories of stresses. `estimates` are
the errors of all these numbers.

Coefficients are empirical: each has a source, and limits of use, in the docstring of its class, and is a
parameter. Plain arrays at the seams: stresses come from anywhere. Theory: docs/theory/wear-and-fatigue.md.
Imports numpy, scipy, `geometries` and `femic.contact`.
"""
