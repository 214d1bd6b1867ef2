"""How large the cells of a section are.

Away from what disturbs it a displacement is smooth on the scale of its distance from there: cells in
proportion to that distance, with polynomials of fourth degree on them, need few unknowns. It is disturbed
at the ends of the loaded strips, at joints (the curvature jumps), and where the contour turns on a
small radius.
"""

from dataclasses import dataclass, replace
from types import ModuleType

import numpy as np

from femic.meshing.cell_size import Cells, distance, round_the_axis, set_cell_size
from geometries.arrays import Array
from geometries.bodies import Body
from geometries.contours import Contour

JOINT = 0.2  # cell at a joint over that of its distance from the nearest strip: a jump disturbs little
TURN = 0.5  # rad, most that the contour turns within a cell
LOCAL = 2.0  # rolling radii from the load along a wheel's axis, beyond which little is left
SAMPLES = 2001  # of the contour, where its curvature is looked at


@dataclass(frozen=True, eq=False)
class SectionSize:
    """Cells of size sqrt(h0^2 + (growth r)^2) at distance r from each disturbance, the least of them.

    h0 is `cells.smallest` at the ends of `strips` (n, 2) [mm] and in proportion to growth elsewhere; on the
    strips themselves cells are not larger than `wave` [mm]. `finer`: other strips, and their h0.
    """

    cells: Cells
    strips: Array
    wave: float = np.inf
    finer: tuple[tuple[Array, float], ...] = ()

    def with_mirror_image(self) -> "SectionSize":
        """Also for what is loaded at -s."""
        finer = tuple((_both_sides(strips), size) for strips, size in self.finer)
        return replace(self, strips=_both_sides(self.strips), finer=finer)


def _both_sides(strips: Array) -> Array:
    return np.vstack([strips, -strips[:, ::-1]])


def set_section_size(gmsh: ModuleType, body: Body, size: SectionSize) -> None:
    """Make it the background field of a model."""
    contour, cells, growth, strips = body.contour, size.cells, size.cells.growth, size.strips
    ends = np.unique(strips)
    disturbances = [(ends, cells.smallest)]
    for joint in contour.joints:
        nearest = max(float(np.min(np.abs(ends - joint))), cells.smallest / growth)
        disturbances.append((np.array([joint]), max(JOINT * growth * nearest, cells.smallest)))
    disturbances += _turns(contour, ends, growth)
    longest = float(np.max(np.ptp(strips, axis=1)))
    if size.wave < growth * longest / 2:
        disturbances.append((_between(strips, size.wave), size.wave))
    disturbances += [(_between(chosen, h0), h0) for chosen, h0 in size.finer]
    fields = [distance(gmsh, np.stack([0 * s, *contour.position(s)])) for s, _ in disturbances]
    formulas = [
        f"sqrt({h0:.17g}^2+({growth:.17g}*F{field})^2)"
        for field, (_, h0) in zip(fields, disturbances, strict=True)
    ]
    if body.rolling_radius < np.inf:
        beyond = f"{growth:.17g}*(F{fields[0]}-{LOCAL * body.rolling_radius:.17g})"
        formulas.append(f"max({round_the_axis(body)},{beyond})")
    set_cell_size(gmsh, formulas)


def _turns(contour: Contour, ends: Array, growth: float) -> list[tuple[Array, float]]:
    """Points where the radius of the contour asks for smaller cells than the distance from the strips does.

    Grouped by size in powers of two.
    """
    if not contour.joints:
        return []
    s = np.linspace(*contour.limits, SAMPLES)
    curvature = np.abs(np.gradient(contour.inclination(s), s))
    size = TURN / np.maximum(curvature, TURN / np.ptp(s))
    apart = np.min(np.abs(s[:, None] - ends), axis=1)
    octave = np.floor(np.log2(size))
    small = size < growth * apart
    return [(s[small & (octave == o)], float(2**o)) for o in np.unique(octave[small])]


def _between(strips: Array, apart: float) -> Array:
    """Points on strips, at most so far apart."""
    n = int(np.ceil(float(np.max(np.ptp(strips, axis=1))) / apart)) + 1
    return np.unique(np.linspace(strips[:, 0], strips[:, 1], n))
