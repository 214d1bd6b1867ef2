"""A wheel that rolls on a rail of another stiffness: what A, B-hat, the mix and B-hat-prime miss there.

The pair of scene `rolling` with Young's moduli of ratios E_upper / E_lower, both chosen so that
1 / E_upper + 1 / E_lower stays the same: A of both then changes in K alone. C of a body goes like 1 / E, so
it is solved once. B-hat-prime has the K of each body, fitted to its C_xn; so has the mix in xn. Shown
are creepages without force, root mean square distances of creep-force curves to those by C over friction
times load, pressures and patches at no creepage. Takes 10 minutes; the picture is OUT/dissimilar_bodies.png,
the numbers are OUT/dissimilar_bodies.nc:

    .venv/bin/python examples/dissimilar_bodies.py [--out FOLDER] [--tolerance 0.03] [--elements 20]
"""

from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import xarray as xr
from cyclopts import run
from matplotlib.figure import Figure

from approx.effective import EffectiveProperties
from approx.matrix import matrix
from approx.pair import Pair, Solid
from compare.calibration.compute import calibrate
from compare.report.styles import MARKERS, STYLES, SYMBOLS
from femic.cache.store import Store
from femic.contact.friction.kinematics import Creepages, Rolling
from femic.contact.frictional import FrictionalProblem
from femic.contact.loading import Loading
from femic.contact.operators.approximations import half_space_operator
from femic.contact.operators.dense import GridOperator
from femic.contact.pairs.automatic_grid import grids_of
from femic.contact.pairs.pair_on_grid import PairOnGrid, pair_on_grid
from femic.contact.pairs.quantities import OF_COMPRESSION, numbers
from femic.contact.pairs.reference_ics import ALL, BodyICs, c_of_bodies, sum_of_bodies
from femic.contact.rolling import RollingContact, RollingProblem
from femic.reference.run_options import RunOptions
from femic.scenes.load import load_scene
from femic.scenes.scene import Scene
from geometries.materials import Material

RATIOS = (0.1, 0.3, 1.0, 3.0, 10.0)
VARIANTS = ("A", "Bhat", "mix", "Bhat_prime")
FRICTION = 0.4
CREEPAGES = (0.0005, 0.001, 0.0015, 0.002, 0.003, 0.004, 0.006, 0.008, 0.012)  # and 0, and these below 0
PATCH = ("p_max", "a", "b")  # numbers of the patch at no creepage
PANELS = {  # variable: label of its axis, factor
    "zero_creepage": ("creepage without force [1e-3]", 1e3),
    "rms": ("curve less that by C, rms [% of friction load]", 100),
    "p_max_error": ("p_max over that by C less 1 [%]", 100),
}


@dataclass(frozen=True, eq=False)
class Bodies:
    """Both bodies on a grid: C of each at the modulus of the scene [mm/MPa], and the K of its B-hat-prime."""

    scene: Scene
    on_grid: PairOnGrid
    c: Mapping[str, BodyICs]
    fits: Mapping[str, EffectiveProperties]

    @classmethod
    def of(cls, scene: Scene, options: RunOptions) -> "Bodies":
        """Solve and fit C of both bodies on the grid that fits the scene's contact."""
        ((grid, _),) = grids_of(scene.contact_problem)
        on_grid = pair_on_grid(scene.contact_problem, grid)
        c, _ = c_of_bodies(scene.contact_problem, on_grid, options, ALL)
        c = {name: body.reciprocal for name, body in c.items()}
        fits = {name: fit.effective for name, fit in calibrate(scene, options).fits.items()}
        return cls(scene, on_grid, c, fits)

    def moduli(self, ratio: float) -> dict[str, float]:
        """E [MPa] by body, with a ratio of upper to lower and the mean of 1 / E that the scene has."""
        compliance = np.mean([1 / body.material.E for body in self.scene.bodies.values()])
        lower = (1 + 1 / ratio) / 2 / compliance
        return {"upper": ratio * lower, "lower": lower}

    def pair(self, ratio: float) -> Pair:
        """The pair with such moduli, as approximations take it: a prismatic wheel."""
        solids = {
            name: Solid(Material(E, body.material.nu), body.surface.prismatic, self.fits[name])
            for name, E in self.moduli(ratio).items()
            for body in [self.scene.bodies[name]]
        }
        return Pair(solids["upper"], solids["lower"])

    def operator(self, ics: str, ratio: float) -> GridOperator:
        """C, or an approximation, of the pair with such moduli."""
        if ics != "C":
            return GridOperator.of(matrix(ics, self.pair(ratio), self.on_grid.grid))
        scaled = {
            name: self.c[name].scaled(self.scene.bodies[name].material.E / E)
            for name, E in self.moduli(ratio).items()
        }
        return GridOperator.of(sum_of_bodies(self.on_grid, scaled, wheel_rolls=True))

    def problem(self, ics: str, ratio: float) -> RollingProblem:
        """The wheel that rolls on the rail."""
        on_grid, contour = self.on_grid, self.scene.bodies["lower"].contour
        strips, radius = on_grid.grid.strips, self.scene.bodies["upper"].rolling_radius
        contact = FrictionalProblem(
            on_grid.grid,
            self.operator(ics, ratio),
            half_space_operator(self.pair(ratio), on_grid.grid),
            on_grid.distance,
            contour.inclination(strips),
            FRICTION,
        )
        height = on_grid.undeformed.upper_height(strips)
        return RollingProblem(contact, Rolling(contour, radius, on_grid.x, strips, height))


def main(*, out: Path = Path("out/examples"), tolerance: float = 0.03, elements: int = 20) -> xr.Dataset:
    """Compute C to estimated errors of `tolerance`, `elements` across the patch; results go to `out`."""
    keys = {
        "calibration": {"bodies": ["upper", "lower"]},
        "contact": {"elements": elements},
        "engine": {"tolerance": tolerance},
    }
    bodies = Bodies.of(load_scene("rolling", keys), RunOptions(store=Store(out / "store")))
    found = compared(
        xr.concat(
            [xr.concat([rolled(bodies, ics, ratio) for ics in (*VARIANTS, "C")], "ics") for ratio in RATIOS],
            "ratio",
        )
    )
    found.to_netcdf(out / "dissimilar_bodies.nc", engine="h5netcdf")
    for name in ("zero_creepage", "rms", *(f"{name}_error" for name in PATCH)):
        print(f"{name}:")
        print(found[name].to_pandas().map("{:.3g}".format))
    draw(found).savefig(out / "dissimilar_bodies.png", dpi=150)
    return found


def rolled(bodies: Bodies, ics: str, ratio: float) -> xr.Dataset:
    """The creep-force curve over friction times load, and the numbers of a contact, by some ICs."""
    problem, load = bodies.problem(ics, ratio), bodies.scene.contact.loads[0]
    contacts = curve(problem, load)
    force = {xi: one.contact.force[0] / (FRICTION * load) for xi, one in contacts.items()}
    guess = float(np.interp(0.0, list(force.values()), list(force)))
    near = contacts[min(contacts, key=lambda xi: abs(xi - guess))].contact
    free = problem.contact(Creepages(guess), Loading(load), forces={"longitudinal": 0.0}, start=near)
    of_patch = numbers(bodies.on_grid, contacts[0.0].contact, OF_COMPRESSION)
    return xr.Dataset(
        {
            "force": ("xi", list(force.values())),
            "zero_creepage": free.creepages.longitudinal,
            **{name: of_patch[name] for name in PATCH},
        },
        coords={"xi": list(force), "ics": ics, "ratio": ratio},
    )


def curve(problem: RollingProblem, load: float) -> dict[float, RollingContact]:
    """The contacts by creepage, growing, each from its neighbour nearer to 0."""
    loading = Loading(load)
    found = {0.0: problem.contact(Creepages(), loading)}
    for sign in (1, -1):
        before = found[0.0]
        for xi in CREEPAGES:
            before = found[sign * xi] = problem.contact(Creepages(sign * xi), loading, start=before.contact)
    return {xi: found[xi] for xi in sorted(found)}


def compared(found: xr.Dataset) -> xr.Dataset:
    """The curves and numbers with their distances to those by C."""
    of_c = found.sel(ics="C", drop=True)
    errors = {f"{name}_error": found[name] / of_c[name] - 1 for name in PATCH}
    return found.assign(rms=((found.force - of_c.force) ** 2).mean("xi") ** 0.5, **errors)


def draw(found: xr.Dataset) -> Figure:
    """What is shown of all ICs over the ratio of moduli."""
    figure = Figure(figsize=(12, 3.8), layout="constrained")
    for axes, (name, (label, factor)) in zip(figure.subplots(1, len(PANELS)), PANELS.items(), strict=True):
        for ics in (str(name) for name in found.ics.values):
            if name == "zero_creepage" or ics != "C":
                style = STYLES[ics] | {"marker": MARKERS[ics], "label": SYMBOLS[ics]}
                axes.plot(found.ratio, factor * found[name].sel(ics=ics), **style)
        axes.set(xscale="log", xlabel="E of the wheel over E of the rail [-]", ylabel=label)
        axes.grid(alpha=0.3)
    figure.axes[0].legend()
    return figure


if __name__ == "__main__":
    run(main, result_action="return_value")
