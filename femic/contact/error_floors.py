"""Floors and scales of error estimates: elements whose state is uncertain, the largest possible forces.

Whether an element slides or sticks is uncertain where the deciding quantity could vanish within the element:
the slip of a sliding element, or the distance of a sticking one's traction from its bound, is less than its
change to a neighbour. Elements beside others in another state are always among them. Where elements slide and
none beside them sticks, all of them may be a place of sticking that the grid is too coarse to show.
"""

from dataclasses import dataclass

import numpy as np

from femic.contact.edges import Extent
from femic.contact.estimates import Scale
from geometries.arrays import Array, Mask
from geometries.patches import N

OF_STATE, OF_WORK, OF_EDGE = 0.1, 0.15, 0.05  # part of tractions on open elements that a force may lack
OF_SLIDING, OF_TURNING = 0.2, 0.5  # part of the area of open elements that may be in another state
OF_AREA = 0.15  # part of the area of elements at the edge that may not be in contact
OF_READING = 2.0  # errors of edges over the accuracy of their readings
NEIGHBOURS = ((1, 0), (-1, 0), (0, 1), (0, -1))
NEARLY = 1 + 1e-9  # beside an element of another state both are the same to rounding


@dataclass(frozen=True, eq=False)
class SlipState:
    """Tractions (n_x, n_s, 3) [MPa] on elements that stick (n_x, n_s) or slip (n_x, n_s, 2).

    `friction` are the coefficients of the strips, (n_s,), or that of all of them.
    """

    p: Array
    stick: Mask
    slip: Array
    friction: Array | float

    @property
    def in_contact(self) -> Mask:
        """The elements in contact."""
        return self.p[..., N] > 0

    @property
    def slides(self) -> Mask:
        """The elements that slide."""
        return self.in_contact & ~self.stick

    @property
    def at_edge(self) -> Mask:
        """The elements at the edge of the contact."""
        return self.in_contact & _beside(~self.in_contact)

    @property
    def open(self) -> Mask:
        """The elements that could be in the other state, of sliding and sticking."""
        size = np.linalg.norm(self.slip, axis=-1)
        inside = np.where(self.in_contact[..., None], self.slip, np.nan)  # no slip is known outside
        margin = self.friction * self.p[..., N] - np.linalg.norm(self.p[..., :N], axis=-1)
        margin = np.where(self.in_contact & self.stick, margin, 0.0)
        could_stick = self.slides & (size <= NEARLY * _change(inside))
        could_slide = self.in_contact & self.stick & (margin <= NEARLY * _change(margin[..., None]))
        return could_stick | could_slide

    @property
    def turning(self) -> Mask:
        """Open elements that slide, with none beside them that sticks."""
        return self.open & self.slides & ~_beside(self.in_contact & self.stick)


def floors(tractions: SlipState) -> dict[str, float]:
    """Floors of estimates [shares of scales] of what rests on the state of elements."""
    pressures = tractions.p[..., N]
    area, load = max(int(np.count_nonzero(tractions.in_contact)), 1), max(float(np.sum(pressures)), 1e-300)

    def part(mask: Mask) -> float:
        return float(np.count_nonzero(mask)) / area

    def of_load(mask: Mask) -> float:
        return float(np.sum(pressures[mask])) / load

    rests_on_state = OF_STATE * of_load(tractions.open) if np.any(tractions.friction) else 0.0
    at_edge = tractions.at_edge
    return {
        "force": rests_on_state + OF_EDGE * of_load(at_edge),
        "work": OF_WORK * rests_on_state / OF_STATE + OF_EDGE * of_load(at_edge),
        "sliding": OF_SLIDING * part(tractions.open) + OF_TURNING * part(tractions.turning),
        "area": OF_AREA * part(at_edge),
        "stiffness": OF_AREA / 2 * part(at_edge),  # it grows like the square root of the area
        "slope": OF_AREA / 2 * part(at_edge) + rests_on_state,  # so does the slope of a curve
    }


def readings(patch: Extent) -> dict[str, float]:
    """Floors of the lengths of a patch along x and s."""
    half_x, half_s = ((high - low) / 2 for low, high in (patch.x, patch.s))
    return {
        "length": OF_READING * patch.accuracy_x / max(half_x, 0.5),
        "width": OF_READING * patch.accuracy_s / max(half_s, 0.5),
    }


@dataclass(frozen=True, eq=False)
class Places:
    """Elements: x (n_x,), y, z (n_s,) [mm], their normals' sine and cosine (n_s,), and area [mm^2]."""

    x: Array
    y: Array
    z: Array
    sin: Array
    cos: Array
    area: float


def scales(pressures: Array, friction: Array | float, at: Places) -> dict[str, Scale]:
    """Scales of forces [N], moments [N mm] and centres [mm] of pressures (n_x, n_s) [MPa].

    `friction` are the coefficients of the strips, (n_s,), or that of all of them.
    Those of changes: friction in any direction on all elements, and pressures as far as their normals and
    levers differ, because the load stays. Rounding is a share of the load, times the largest lever.
    """
    forces = at.area * pressures
    load, x = max(float(np.sum(forces)), 1e-300), at.x[:, None]
    in_contact = forces > 0

    def apart(lever: Array) -> float:
        return float(np.sum(forces * np.abs(lever - np.sum(forces * lever) / load)))

    def of_friction(lever: Array | float) -> float:
        return float(np.sum(friction * forces * lever))

    def reach(lever: Array) -> float:
        return float(np.max(np.where(in_contact, lever, 0.0), initial=0.0))

    of_x, of_y, of_z = np.broadcast_arrays(x, at.y, at.z)
    tilt = np.broadcast_to(at.sin, forces.shape)
    about_x, about_z = np.hypot(of_y, of_z), np.hypot(of_x, of_y)
    return {
        "longitudinal": Scale(of_friction(1.0), load),
        "lateral": Scale(of_friction(1.0) + apart(tilt), load),
        "about_x": Scale(of_friction(about_x) + apart(at.y * at.cos - at.z * at.sin), load * reach(about_x)),
        "about_z": Scale(of_friction(about_z) + apart(x * tilt), load * reach(about_z)),
        "centre": Scale(apart(of_y) / load, reach(np.abs(of_y))),
    }


def _beside(mask: Mask) -> Mask:
    """Return elements with a neighbour that is in a mask; outside the grid none is."""
    return np.any([_moved(mask, side, fill=False) for side in NEIGHBOURS], axis=0)


def _change(values: Array) -> Array:
    """Return the largest distance of vectors (n_x, n_s, k) to those of neighbours; NaN ones do not count."""
    away = [np.linalg.norm(values - _moved(values, side, fill=np.nan), axis=-1) for side in NEIGHBOURS]
    return np.asarray(np.max(np.nan_to_num(away), axis=0))


def _moved(values: Array | Mask, side: tuple[int, int], fill: float) -> Array:
    """Return the values of neighbours on one side, shape as of `values`."""
    padded = np.pad(values, [(1, 1), (1, 1), *[(0, 0)] * (values.ndim - 2)], constant_values=fill)
    n_x, n_s = values.shape[:2]
    return np.asarray(padded[1 + side[0] : 1 + side[0] + n_x, 1 + side[1] : 1 + side[1] + n_s])
