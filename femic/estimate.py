"""The estimate of C's error, from models that are less accurate in one way each.

By the solid engine every body is solved on three models: fine, coarse (cells `COARSER` times as large) and
small (the coarse cells in a domain half as large); by the harmonic engine on two, fine and coarse, each
also with a nearer far arc and with fewer wavenumbers. The differences give the parts of the
estimate, as in Roache's grid convergence index. The estimate assumes order 2 of the mesh, because its errors
are partly random: two meshes may agree by luck; order 1 on the outline of the patch, where the traction
jumps; and order 1 of the truncation close to the far arc.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, fields

import numpy as np

from femic.level import COARSER, LARGER, TRUNCATION_ORDER
from femic.models import Points
from geometries.arrays import Array
from geometries.patches import Patch

ESTIMATE_ORDER = 2  # in cell size, assumed by the estimate
LOW_ORDER = 1  # likewise on the outline of the patch; and in 1 / domain size, close to the far arc
ON_OUTLINE = 0.2  # least half-sides: what is on the outline
CLOSE_TO_ARC = 1 / 3  # far radii from the load on
SAFETY = 1.25  # Roache's factor
WAVES_GAIN = {"sparser": 32.0, "lower": 3.0}  # error with the perturbed wavenumbers over that with all


@dataclass(frozen=True)
class Estimated:
    """ICs per unit total load [mm/N], shape (3, 3, n), after the discount; NaN where nothing was solved."""

    ic: Array
    mesh_error: Array  # estimates of the parts of its error, not negative
    truncation_error: Array
    waves_error: Array  # of the interpolation between wavenumbers; 0 of the solid engine

    @property
    def estimate(self) -> Array:
        """Estimate of the error of `ic`."""
        return self.mesh_error + self.truncation_error + self.waves_error


def total(parts: Sequence[Estimated]) -> Estimated:
    """The sum over some bodies; their estimates add up."""
    return Estimated(
        *(np.sum([getattr(part, field.name) for part in parts], axis=0) for field in fields(parts[0]))
    )


@dataclass(frozen=True)
class Orders:
    """Orders of convergence that an estimate assumes, everywhere or at each point, (n,)."""

    mesh: Array | float = ESTIMATE_ORDER
    truncation: Array | float = TRUNCATION_ORDER


ALIKE_EVERYWHERE = Orders()


def orders_at(patch: Patch, points: Points, far_radius: float) -> Orders:
    """Lower ones where gradients are infinite, and where half the domain hardly contains a point."""
    x, s = np.abs(points.x), np.abs(points.s - patch.s)
    reach = ON_OUTLINE * min(patch.a, patch.b)
    around = (x < patch.a + reach) & (s < patch.b + reach)
    on_outline = around & ((x > patch.a - reach) | (s > patch.b - reach))
    close = np.hypot(x, s) > CLOSE_TO_ARC * far_radius
    return Orders(
        np.where(on_outline, LOW_ORDER, ESTIMATE_ORDER), np.where(close, LOW_ORDER, TRUNCATION_ORDER)
    )


def estimated(
    ic: Array, coarse: Array, less: Mapping[str, Array], *, safety: float, orders: Orders = ALIKE_EVERYWHERE
) -> Estimated:
    """ICs with estimates of their error, from those with coarser cells and with less of other things.

    `less`: "nearer" boundaries, and of the harmonic engine "sparser" and "lower" wavenumbers; `safety`: of
    the part from the mesh.
    """
    waves = [np.abs(ic - less[name]) / (gain - 1) for name, gain in WAVES_GAIN.items() if name in less]
    return Estimated(
        ic,
        pooled(safety * np.abs(ic - coarse) / (COARSER**orders.mesh - 1)),
        SAFETY * np.abs(ic - less["nearer"]) / (LARGER**orders.truncation - 1),
        SAFETY * np.sum([np.zeros_like(ic), *waves], axis=0),
    )


def pooled(error: Array) -> Array:
    """Errors (3, 3, ...) of ij not below those of ji: they are errors of the same kind, one lucky or not."""
    both = np.fmax(error, np.swapaxes(error, 0, 1))
    return np.where(np.isnan(error), np.nan, both)
