"""The boundary of a section as Gmsh curves: contact contour, and far arc and hub, or an outline.

The curves may deviate a little from the true contour; the meshes move their nodes onto it.
"""

from collections.abc import Sequence
from itertools import pairwise
from types import ModuleType

import numpy as np

from geometries.arrays import Array
from geometries.bodies import Body
from geometries.contours import Contour

SAMPLES_PER_CURVE = 81  # points of the contour per curve of Gmsh


def add_section(
    gmsh: ModuleType, body: Body, *, half_section: bool, breaks: Sequence[float] = ()
) -> tuple[int, list[int]]:
    """Add the section as a plane surface in x = 0; returns its tag and those of the contour's curves.

    With `half_section` only y >= 0 is added. The contour consists of one curve per smooth piece; it is also
    divided at the arc lengths `breaks` [mm].
    """
    s_left, s_right = body.s_range
    inner = [*body.contour.joints, *breaks]
    ends, curves = _add_contour(gmsh, body.contour, (0.0 if half_section else s_left, s_right), inner)
    add_closing = _add_closing if body.outline is None else _add_outline
    closing = add_closing(gmsh, body, ends, half_section)
    loop = gmsh.model.occ.addCurveLoop([*curves, *closing])
    return int(gmsh.model.occ.addPlaneSurface([loop])), curves


def _add_closing(gmsh: ModuleType, body: Body, ends: tuple[int, int], half_section: bool) -> list[int]:
    """Add curves from the contour's right end along far arc and hub to its left end; returns their tags."""
    occ, far = gmsh.model.occ, body.domain.far_radius
    centre = occ.addPoint(0, 0, 0)
    top = min(far, body.depth)
    corner = np.sqrt(far**2 - top**2)  # where far arc and hub meet; 0 without a hub
    pole = occ.addPoint(0, 0, body.side * top)

    def to_pole(end: int, s: float, side: int) -> list[int]:
        z = body.contour.position(s)[1]
        if body.side * z > (1 - 1e-9) * body.depth:
            return [occ.addLine(end, pole)]
        if not corner:
            return [occ.addCircleArc(end, centre, pole)]
        hub_end = occ.addPoint(0, side * corner, body.side * top)
        return [occ.addCircleArc(end, centre, hub_end), occ.addLine(hub_end, pole)]

    right = to_pole(ends[1], body.s_range[1], +1)
    left = [occ.addLine(pole, ends[0])] if half_section else to_pole(ends[0], body.s_range[0], -1)[::-1]
    return [*right, *left]


def _add_outline(gmsh: ModuleType, body: Body, ends: tuple[int, int], half_section: bool) -> list[int]:
    """Add the edges of the outline from the contour's right end to its left end; returns their tags."""
    assert body.outline is not None
    points = (
        body.outline.right_half_beyond(body.contour) if half_section else body.outline.beyond(body.contour)
    )
    tags = [ends[1], *(gmsh.model.occ.addPoint(0, y, z) for y, z in points.T), ends[0]]
    return [gmsh.model.occ.addLine(*pair) for pair in pairwise(tags)]


def _add_contour(
    gmsh: ModuleType, contour: Contour, s_range: tuple[float, float], inner: list[float]
) -> tuple[tuple[int, int], list[int]]:
    """Add curves along the contour; returns the tags of its end points and of the curves."""
    s_start, s_end = s_range
    breaks = np.unique([s_start, *(s for s in inner if s_start < s < s_end), s_end])
    tags = [gmsh.model.occ.addPoint(0, *contour.position(s)) for s in breaks]
    curves = [
        _add_piece(gmsh, contour, np.linspace(breaks[k], breaks[k + 1], SAMPLES_PER_CURVE), tags[k : k + 2])
        for k in range(len(breaks) - 1)
    ]
    return (tags[0], tags[-1]), curves


def _add_piece(gmsh: ModuleType, contour: Contour, s: Array, ends: list[int]) -> int:
    """Add a line or a spline through the contour at arc lengths s [mm]; returns its tag."""
    occ = gmsh.model.occ
    if np.ptp(contour.inclination(s)) < 1e-12:
        return int(occ.addLine(*ends))
    inner = [occ.addPoint(0, y, z) for y, z in contour.position(s[1:-1]).T]
    return int(occ.addSpline([ends[0], *inner, ends[1]]))
