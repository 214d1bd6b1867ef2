"""Stresses and displacements inside the bodies under given tractions.

Imports femic.reference (sections, wavenumbers), approx and geometries; nothing here knows how the tractions
were computed. The parts, lowest first:

- `tractions`: `SurfaceTractions(grid, p)`, p (n_x, n_s, 3) [MPa] along x, s, n as they act on the upper body
  (the lower one gets the opposite: pass the same p for both);
- `points`: `InnerPoints(x, s, depth)`, arrays of one shape (...); `line_into_depth`, `section_points`,
  `lengthwise_points`, `points_at(body, x, y, z)`; `require_inside`;
- `field`: `StressField`: displacements (..., 3) and stresses (..., 3, 3) in local axes x, s, n;
- `measures`: von Mises, Tresca, principal values of stresses (..., 3, 3); the largest value and its place;
- `half_space`: closed forms for rectangles of uniform traction, `half_space_field(body, tractions, points)`;
- `engine`: `stress_field(body, tractions, points, settings)`, in the true body, with an estimate, the
  half-space's stresses beside it (`StressField.half_space`); `StressSettings(fineness, estimated, workers)`.

Theory: docs/theory/stresses.md.
"""
