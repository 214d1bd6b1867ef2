"""The estimate of C's error, from models that are less accurate in one way each.

The solid engine solves every body on three models: fine, coarse (cells `COARSER` times as large) and small
(the coarse cells in a domain half as large). The harmonic engine varies a single model: coarser cells, a
nearer far arc, and fewer wavenumbers. The differences give the parts of the estimate, as in Roache's grid
convergence index. The estimate assumes order 2 in the cell size, because the errors of meshes are partly
random and two meshes may agree by chance; order 1 on the outline of the patch, where the traction is
discontinuous; and order 1 in the domain size close to the far arc.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, fields

import numpy as np

from femic.reference.level import COARSER, LARGER, TRUNCATION_ORDER
from femic.reference.models import Points
from geometries.arrays import Array
from geometries.patches import Patch

ESTIMATE_ORDER = 2  # in cell size, assumed by the estimate
LOW_ORDER = 1  # assumed on the outline of the patch, and in 1 / domain size close to the far arc
ON_OUTLINE = 0.2  # distance from the outline, in least half-sides, up to which a point is on it
CLOSE_TO_ARC = 1 / 3  # distance from the load, in far radii, from which on a point is close to the arc
SAFETY = 1.25  # Roache's factor
WAVES_GAIN = {"sparser": 32.0, "lower": 3.0}  # error with these wavenumbers over that with all


@dataclass(frozen=True)
class EstimatedICs:
    """ICs per unit total load [mm/N], shape (3, 3, n), after the discount; NaN where nothing was solved."""

    ic: Array
    mesh_error: Array  # estimate of this part of the error of `ic` [mm/N], not negative; so the next two
    truncation_error: Array
    waves_error: Array  # from the wavenumbers; 0 for the solid engine

    @property
    def errors(self) -> tuple[Array, Array, Array]:
        """The parts of the estimated error of `ic` [mm/N], (3, 3, n) each: mesh, truncation, wavenumbers."""
        return self.mesh_error, self.truncation_error, self.waves_error

    @property
    def estimate(self) -> Array:
        """The estimated error of `ic` [mm/N], shape (3, 3, n)."""
        return self.mesh_error + self.truncation_error + self.waves_error


def total(parts: Sequence[EstimatedICs]) -> EstimatedICs:
    """Return the sum of the ICs of bodies, with the sum of their estimates."""
    return EstimatedICs(
        *(np.sum([getattr(part, field.name) for part in parts], axis=0) for field in fields(parts[0]))
    )


@dataclass(frozen=True)
class Orders:
    """Orders of convergence that an estimate assumes, everywhere or at each point, (n,)."""

    mesh: Array | float = ESTIMATE_ORDER
    truncation: Array | float = TRUNCATION_ORDER


ALIKE_EVERYWHERE = Orders()


def orders_at(patch: Patch, points: Points, far_radius: float) -> Orders:
    """Return the orders at points: lower where gradients are infinite, and close to the far arc."""
    x, s = np.abs(points.x), np.abs(points.s - patch.s)
    margin = ON_OUTLINE * min(patch.a, patch.b)
    around = (x < patch.a + margin) & (s < patch.b + margin)
    on_outline = around & ((x > patch.a - margin) | (s > patch.b - margin))
    close_to_arc = np.hypot(x, s) > CLOSE_TO_ARC * far_radius
    return Orders(
        np.where(on_outline, LOW_ORDER, ESTIMATE_ORDER), np.where(close_to_arc, LOW_ORDER, TRUNCATION_ORDER)
    )


def estimated(
    ic: Array,
    perturbed: Mapping[str, Array],
    *,
    safety: float,
    orders: Orders = ALIKE_EVERYWHERE,
) -> EstimatedICs:
    """Return ICs (3, 3, ...) [mm/N] with their estimated errors, from less accurate ICs of the same shape.

    `perturbed` has ICs with "coarser" cells, with "nearer" boundaries unless these are part of the body, and
    with the "sparser" and "lower" wavenumbers of the harmonic engine. `safety` is the factor on the part from
    the mesh.
    """
    changes = {name: less_accurate - ic for name, less_accurate in perturbed.items()}
    return EstimatedICs(ic, *errors(changes, safety=safety, orders=orders))


def errors(
    changes: Mapping[str, Array], *, safety: float, orders: Orders = ALIKE_EVERYWHERE
) -> tuple[Array, Array, Array]:
    """Return the errors [mm/N] due to mesh, truncation, wavenumbers from the `changes` of less accurate ICs.

    Their names and `safety` are those of `estimated`.
    """
    none = np.zeros_like(changes["coarser"])
    mesh = safety * np.abs(changes["coarser"]) / (COARSER**orders.mesh - 1)
    truncation = SAFETY * np.abs(changes.get("nearer", none)) / (LARGER**orders.truncation - 1)
    waves = [np.abs(changes[name]) / (gain - 1) for name, gain in WAVES_GAIN.items() if name in changes]
    return pooled(mesh), truncation, SAFETY * sum(waves, start=none)


def pooled(error: Array) -> Array:
    """Return the larger of the errors of ij and ji, in the shape (3, 3, ...) of `error`; NaN stays NaN.

    Both errors are of the same kind, and one of them may be small by chance.
    """
    larger = np.fmax(error, np.swapaxes(error, 0, 1))
    return np.where(np.isnan(error), np.nan, larger)
