"""Results whose C is made by hand, for measures whose numbers are then known; no finite elements."""

from collections.abc import Callable
from dataclasses import dataclass, field, replace
from functools import cache

import numpy as np

from approx.pair import Solid
from compare.validation.statements.curves import CONCAVE, CONVEX, unit
from compare.validation.statements.runs import GEOMETRIES
from femic.reference.discount import FY, MOMENT
from femic.reference.engine import Points
from femic.reference.result import EstimatedICs, Reference
from femic.results.ics import Results, approximate_all, scene_points
from femic.scenes.load import load_scene
from geometries.patches import COMPONENTS, N

FIT = {"combined": {"mismatch_k": {"far": 0.1, "r_inf": 20.0, "m": 1.0, "n": 2.0}}}
STIFF, SOFT = 630e3, 70e3


@dataclass(frozen=True)
class ApproximatedBody:
    """What a hand-made C may be made of: a body of a geometry, its approximations [mm/N], and the points."""

    name: str
    body: str
    results: Results  # without C

    @property
    def points(self) -> Points:
        return self.results.points

    @property
    def a(self) -> np.ndarray:
        return self.by("A")

    def by(self, variant: str) -> np.ndarray:
        return self.results.approximations[variant, self.body]

    def half_by(self, variant: str) -> np.ndarray:
        """Half of the combined ICs: those of both bodies add up to them."""
        return self.results.approximations[variant, "combined"] / 2

    def prismatic(self, variant: str) -> np.ndarray:
        """Without curvature along x."""
        scene = self.results.scene
        solid = getattr(scene.pair, self.body)
        flat = Solid(solid.material, solid.surface.prismatic)
        return flat.approximate(variant, scene.patch, (self.points.x, self.points.s)) / scene.patch.area

    def on(self, line: str) -> np.ndarray:
        """Which points lie on a line."""
        mask = np.zeros(len(self.points.x), dtype=bool)
        mask[self.results.lines[line]] = True
        return mask

    @property
    def bump(self) -> np.ndarray:
        """Something even, large at the load, in mm/N of the size of A."""
        scale = 0.1 / unit(self.results)
        return scale * np.exp(-(self.points.x**2 + self.points.s**2) / 30)


Made = Callable[[ApproximatedBody], np.ndarray]


@cache
def without_c(name: str, *, fitted: bool = False, upper_E: float = 210e3) -> Results:
    """A geometry, or the plane, with its approximations."""
    variants = ["A", "B", "Bbar", "Bhat", "mix"] + ["Bhat_prime"] * fitted
    changes = {"components": list(COMPONENTS), "variants": variants, "engine": {"check": False}}
    changes |= {"upper": {"E": upper_E}} | ({"effective": FIT} if fitted else {})
    scene = load_scene(name, changes)
    approximations, seconds = approximate_all(scene, scene_points(scene)[0])
    return Results(scene, {}, {}, approximations, seconds)


def with_c(results: Results, c: Made, *, estimate: float = 0.0, rotation: dict | None = None) -> Results:
    """The same with a C; `estimate` as a share of the largest A_nn, `rotation` by body."""
    references = {}
    for body in (CONVEX, CONCAVE):
        of = ApproximatedBody(results.scene.name, body, results)
        ic = c(of)
        known = np.full_like(ic, estimate * np.max(of.a[N, N]))
        zero = np.zeros_like(ic)
        m = np.zeros((4, 4))
        m[FY, MOMENT] = m[MOMENT, FY] = (rotation or {}).get(body, 0.0)
        estimated = EstimatedICs(ic, known, zero, zero)
        references[body] = Reference(estimated, ic, m, None, None, results.scene.bodies[body], {})
    return replace(results, references=references)


@dataclass
class Runs:
    """Hand-made runs; those that are not given are not used."""

    geometries: dict[str, Results]
    others: dict[str, Results] = field(default_factory=dict)
    prismatic: Results | None = None
    flat: Results | None = None

    def geometry(self, name):
        return self.geometries[name]

    fitted = with_both_engines = geometry

    def other_nu(self, name):
        return self.others[name]

    def not_revolved(self):
        return self.prismatic

    def plane(self):
        return self.flat

    nearly_plane = plane


def runs_of(c: Made, *, fitted: bool = False, upper_E: float = 210e3, **named) -> Runs:
    """Both geometries with a C."""
    return Runs(
        {name: with_c(without_c(name, fitted=fitted, upper_E=upper_E), c, **named) for name in GEOMETRIES}
    )


def times(variant: str, component: tuple[int, int] | None, factor) -> Made:
    """A variant, one component (None: all) times a number, or times a function of what C is made of."""

    def c(of):
        out = of.by(variant).copy()
        out[component if component else ...] *= factor(of) if callable(factor) else factor
        return out

    return c


def between(first: str, second: str, share: float) -> Made:
    """From one variant to another."""
    return lambda of: of.by(first) + share * (of.by(second) - of.by(first))


def by_body(convex: float, concave: float) -> Callable[[ApproximatedBody], float]:
    return lambda of: convex if of.body == CONVEX else concave


def by_geometry(first: float, second: float) -> Callable[[ApproximatedBody], float]:
    return lambda of: first if of.name == GEOMETRIES[0] else second


def made(name: str, c: Made, *, fitted: bool = False, **named) -> Results:
    """A geometry with a C."""
    return with_c(without_c(name, fitted=fitted), c, **named)
