"""What a model of the harmonic engine is solved for, and which wavenumbers that takes."""

from dataclasses import dataclass

import numpy as np

from femic.engine import Specification
from femic.estimate import WAVES_GAIN
from femic.harmonic.wavenumbers import Axis
from femic.level import HIGHER, WAVES_ORDER
from femic.meshing.cell_size import Cells
from femic.models import Points
from geometries.arrays import Array
from geometries.bodies import Body
from geometries.patches import Load, Patch

TUNED_TOLERANCE = 0.001  # that the wavenumbers below meet
LOWEST = 0.7  # scale of the wavenumbers, times 1 / far radius: below it the clamped far arc rules
HIGHEST = 2 * np.pi  # largest wavenumber, times 1 / least half-side: beyond it the half-space does
CURVED = 0.05  # half-side over radius of curvature from which on larger wavenumbers are needed
ROUNDING = 0.25  # of a step of pi / a or 2 pi / a that the largest wavenumber may fall short
FAR_REACH = 7.0  # lengths 1 / k beyond which the far arc is not felt
NEARER = 2.0  # far radius over the one of the check
WAVES_SHARE = 0.5  # of the tolerance that the interpolation between wavenumbers may take
LOOSEST_WAVES = 0.01  # tolerance: with fewer wavenumbers their gain is not yet that of the spline


@dataclass(frozen=True)
class HarmonicRequest:
    """What one model is solved for; points are relative to each load in x, only their s matters here.

    `cells`: smallest and growth, away from the ends of the loaded strips; with `even_strips` all cells on
    the strips are of the smallest size, near the patches `exact` they are `FINER` times smaller.
    `accuracy` [mm/N], one or one each (load, 1, observer), is asked of the interpolation between
    wavenumbers; `highest`, times the least half-side of the loads, is the largest of them.
    """

    body: Body
    loads: tuple[Load, ...]
    points: Points
    cells: Cells
    accuracy: Array | float
    highest: float = HIGHEST
    even_strips: bool = False
    exact: tuple[Patch, ...] = ()

    @property
    def k_max(self) -> float:
        """Largest wavenumber [1/mm]: the more curved the surface under the loads, the larger.

        There the patch's own weight sin(k a) / (k a) is 0, and at half of it, too, if `highest` is 2 pi or
        more: little is cut off.
        """
        patches = [load.patch for load in self.loads]
        bend = max(_curvature(self.body, patch.s, patch.b) * max(patch.a, patch.b) for patch in patches)
        a, b = min(patch.a for patch in patches), min(patch.b for patch in patches)
        needed = self.highest / min(a, b) * max(1.0, bend / CURVED) ** 0.5
        step = min(HIGHEST, self.highest) / a
        return step * int(np.ceil(needed / step - ROUNDING))

    @property
    def observed(self) -> Array:
        """Arc lengths [mm] where the responses are read, each once."""
        return np.unique(self.points.s)

    @property
    def felt(self) -> float:
        """Wavenumber [1/mm] from which on the nearer of the two far arcs is not felt."""
        return FAR_REACH * NEARER / self.body.domain.far_radius

    @property
    def determined_by(self) -> tuple[object, ...]:
        """All that the responses depend on."""
        size = self.cells, self.even_strips, self.exact
        return self.body, self.loads, self.observed, size, self.accuracy, self.axis

    @property
    def axis(self) -> Axis:
        """The axis of wavenumbers."""
        return Axis(LOWEST / self.body.domain.far_radius, self.k_max, self.body.rolling_radius)


def _curvature(body: Body, s: float, b: float) -> float:
    """Largest curvature [1/mm] of the surface over a strip."""
    turn = float(np.ptp(body.contour.inclination(np.linspace(s - b, s + b, 9)))) / (2 * b)
    return max(turn, 1 / float(body.surface.circle_radius(s)))


def request_for(asked: Specification) -> HarmonicRequest:
    """The request for a model, its wavenumbers as dense as the least scale of refinement needs."""
    accuracy, larger = waves_for(asked.tolerance, asked.least_scale, asked.waves)
    return HarmonicRequest(asked.body, asked.loads, asked.points, asked.cells, accuracy, larger * HIGHEST)


def waves_for(tolerance: float, least_scale: float, steps: int) -> tuple[float, float]:
    """How accurate the interpolation between wavenumbers must be [mm/N], and how much larger the largest.

    `steps`: of refinement.
    """
    accuracy = WAVES_SHARE * min(tolerance, LOOSEST_WAVES) * least_scale / WAVES_GAIN["sparser"] ** steps
    tighter = max(1.0, TUNED_TOLERANCE / tolerance)
    return accuracy, HIGHER**steps * tighter ** (1 / WAVES_ORDER)
