"""The request for a model of the harmonic engine: the far arc and the wavenumbers that a tolerance needs."""

from dataclasses import dataclass, replace

import numpy as np

from femic.reference.engine import Points, Request
from femic.reference.harmonic.waves import Axis
from femic.reference.meshing import Cells
from femic.reference.result import WAVES_GAIN
from femic.reference.run_options import COARSER, HIGHER, WAVES_ORDER
from geometries.arrays import Array
from geometries.bodies import Body
from geometries.patches import Load, Patch

# --- the first model ---

TUNED_TOLERANCE = 0.001  # that the first cells meet on the built-in scenes
FAR_RADIUS = 1280.0  # mm, of the far arc at the tuned tolerance
HIGHEST = 2 * np.pi  # largest wavenumber times the least half-side: beyond it the half-space rules
WAVES_SHARE = 0.5  # share of the tolerance that the interpolation between wavenumbers may take
LOOSEST_WAVES = 0.01  # loosest tolerance of the interpolation: with fewer wavenumbers halving gains less


def tightening(tolerance: float) -> float:
    """Return the factor by which a tolerance is tighter than the tuned one, at least 1."""
    return max(1.0, TUNED_TOLERANCE / tolerance)


# --- the request ---

SCALE_LOWEST = 0.7  # scale of the wavenumbers times the far radius: below it the clamped far arc rules
CURVED_FROM = 0.05  # half-side over radius of curvature beyond which larger wavenumbers are needed
FAR_REACH = 7.0  # lengths 1 / k beyond which the far arc has no effect
WAVES_OVERESTIMATE = 4.0  # on strips: expected over actual error of the interpolation between wavenumbers
HIGHEST_OF_FIT = 9 * np.pi  # largest wavenumber times the least half-side: M needs more digits than C
COLUMNS_NEED = 1 / 2  # largest wavenumber that columns of an IC matrix need over the one that M needs
NEARER = 2.0  # far radius over the radius of the nearer far arc, which shows the truncation error


@dataclass(frozen=True)
class HarmonicRequest:
    """The input of one model; of the points, only s matters here.

    `cells` gives the smallest cell and its growth away from the ends of the loaded strips. `on_strips` all
    cells have the smallest size; near `fit_patches`, where M is fitted, they are smaller
    (`femic.reference.harmonic.engine.FINER`). `accuracy` [mm/N], a number or an array (load, 1, observer),
    limits the error of the interpolation between wavenumbers. `highest` is the largest wavenumber times the
    least half-side of loads. The other fields are those of `Request`. Models with spare loads and arc lengths
    serve later requests (`femic.reference.harmonic.stored`).
    """

    body: Body
    loads: tuple[Load, ...]
    points: Points
    cells: Cells
    accuracy: Array | float
    highest: float = HIGHEST
    on_strips: bool = False
    fit_patches: tuple[Patch, ...] = ()
    spare_loads: tuple[Load, ...] = ()
    spare_s: tuple[float, ...] = ()
    given_domain: bool = False

    @property
    def requested_loads(self) -> tuple[Load, ...]:
        """The loads without the spare ones."""
        return tuple(load for load in self.loads if load not in self.spare_loads)

    @property
    def requested_s(self) -> Array:
        """The arc lengths of `observed` without the spare ones [mm], shape (n,)."""
        return np.setdiff1d(self.observed, self.spare_s)

    @property
    def k_max(self) -> float:
        """Largest wavenumber [1/mm]: the more curved the surface under the loads, the larger."""
        patches, contour = [load.patch for load in self.requested_loads], self.body.contour
        relative_curvature = 0.0
        for patch in patches:
            s, b = patch.s, patch.b
            turn = float(np.ptp(contour.inclination(np.linspace(s - b, s + b, 9)))) / (2 * b)
            curvature = max(turn, 1 / float(self.body.surface.circle_radius(s)))
            relative_curvature = max(relative_curvature, curvature * max(patch.a, b))
        a, b = min(patch.a for patch in patches), min(patch.b for patch in patches)
        return self.highest / min(a, b) * max(1.0, relative_curvature / CURVED_FROM) ** 0.5

    @property
    def coarser(self) -> "HarmonicRequest":
        """The same request with coarser cells, which show the error of the mesh."""
        return replace(self, cells=self.cells.scaled(COARSER))

    @property
    def observed(self) -> Array:
        """Arc lengths [mm] where the responses are read, in growing order without repetitions, shape (n,)."""
        return np.unique(self.points.s)

    @property
    def shares(self) -> tuple[float, ...]:
        """Shares of the far radius at which the far arc lies: its own, and the nearer one.

        A body with an outline has its supports only.
        """
        return (1.0, 1 / NEARER) if self.body.outline is None else (1.0,)

    @property
    def cutoff_wavenumber(self) -> float:
        """Wavenumber [1/mm] from which on the nearer far arc has no effect on the responses."""
        return FAR_REACH * NEARER / self.body.domain.far_radius

    @property
    def determined_by(self) -> tuple[object, ...]:
        """All inputs that the responses depend on."""
        size = self.cells, self.on_strips, self.fit_patches
        return self.body, self.loads, self.observed, size, self.accuracy, self.axis

    @property
    def axis(self) -> Axis:
        """The axis of wavenumbers."""
        return Axis(SCALE_LOWEST / self.body.domain.far_radius, self.k_max, self.body.rolling_radius)


def request_for(model: Request) -> HarmonicRequest:
    """Return the request for a model, with wavenumbers as dense as the least scale of refinement needs."""
    scale, highest = model.least_scale, HIGHEST
    if model.on_strips:
        scale, highest = WAVES_OVERESTIMATE * scale, HIGHEST_OF_FIT
    tolerance = min(model.tolerance, LOOSEST_WAVES)
    return HarmonicRequest(
        model.body,
        model.loads,
        model.points,
        model.cells,
        WAVES_SHARE * tolerance * scale / WAVES_GAIN["sparser"] ** model.waves,
        highest * HIGHER**model.waves * tightening(model.tolerance) ** (1 / WAVES_ORDER),
        model.on_strips,
        model.fit_patches,
        model.spare_loads,
        model.spare_s,
        model.given_domain,
    )
