"""Stresses and displacements inside the bodies under given tractions.

Imports femic.reference (sections, wavenumbers), approx and geometries; nothing here knows how the tractions
were computed. The parts, lowest first:

- `points`: `InnerPoints(x, s, depth)`, arrays of one shape (...); `points_at(body, x, y, z)`;
  `require_inside`; and `SurfaceTractions(grid, p)`, p (n_x, n_s, 3) [MPa] along x, s, n as they act on the
  upper body (the lower one gets the opposite: pass the same p for both);
- `field`: `StressField`: displacements (..., 3) and stresses (..., 3, 3) in local axes x, s, n; von Mises,
  Tresca, principal values of stresses (..., 3, 3); what the largest one on a lattice may miss;
- `near_surface`: samples of a smooth field, and its continuation to the surface;
- `half_space`: closed forms for rectangles of uniform traction, `half_space_field(body, tractions, points)`;
- `waves`: tractions as waves along x, and the fields of a section under them;
- `engine`: `stress_field(body, tractions, points, settings)`, in the actual body, with an estimate, the
  half-space's stresses beside it (`StressField.half_space`); `StressSettings(fineness, estimated, workers)`;
  `resolution` says what a fineness means.

Theory: docs/theory/stresses.md.
"""
