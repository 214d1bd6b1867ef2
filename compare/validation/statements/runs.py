"""The runs that statements need, each computed when it is first used."""

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field, replace
from functools import wraps
from typing import Any, TypeVar

import xarray as xr

from approx.effective import EffectiveProperties
from approx.variants import VARIANTS
from compare.validation.statements.contact_series import ContactSeries
from femic.contact.finite_elements import CELLS
from femic.contact.pairs.ics import NONE_GIVEN, GivenICs
from femic.reference.run_options import RunOptions
from femic.results.calibration import calibrate
from femic.results.contact import compute_contact
from femic.results.finite_elements import compute_fe_contact
from femic.results.friction import compute_with_friction
from femic.results.ics import Results, compute, with_approximations
from femic.scenes.load import load_scene
from femic.scenes.scene import Scene
from geometries.patches import COMPONENTS

GEOMETRIES = ("geometry1", "geometry2")
OTHER_NU = {"geometry1": 0.30, "geometry2": 0.28}
SERIES_LOADS = {  # N, of contacts under any load: patches turn by less than 20 to more than 100 degrees
    "wide": (60e3, 24e6),  # under larger ones the linearised distance closes at the end of the ellipse, too
    "tall": (0.35e3, 340e3),
}
NEARLY_PLANE = 1e4  # mm, radius of the arcs

Value = TypeVar("Value")


@dataclass(frozen=True)
class Contacts:
    """Contacts of a built-in scene: loads [N], shift of the upper body along y [mm], fineness of meshes.

    `cells` lie along the shorter half-length of the patch.
    """

    scene: str
    loads: tuple[float, ...]
    shift: float = 0.0
    cells: float = CELLS


@dataclass(eq=False)
class Runs:
    """Results of scenes with all nine components of C and every variant, each computed once."""

    options: RunOptions
    tolerance: float  # of C
    done: dict[str, Results] = field(default_factory=dict)  # ICs by the name of the run
    known: dict[str, Any] = field(default_factory=dict)  # everything else, by what it is

    def geometry(self, name: str) -> Results:
        """Return the results of a geometry of the source [BVSV]."""
        return self._solve(name, lambda: self._scene(name))

    def fitted(self, name: str) -> Results:
        """Return the results of a geometry with B-hat-prime, fitted to the same geometry."""

        def fit() -> Results:
            results = self.geometry(name)
            scene = replace(results.scene, effective=self._fit(name), variants=tuple(VARIANTS))
            return with_approximations(results, scene)

        return self.once(f"{name}, fitted", fit, self.done)

    def with_both_engines(self, name: str) -> Results:
        """Return the results of a geometry with C of both engines."""
        return self._solve(f"{name}, both engines", lambda: self._scene(name, check=True))

    def other_nu(self, name: str) -> Results:
        """Return the results of a geometry with the Poisson's ratio of the other geometry."""
        nu = {"nu": OTHER_NU[name]}
        return self._solve(
            f"{name}, nu = {OTHER_NU[name]:.2f}", lambda: self._scene(name, {"lower": nu, "upper": nu})
        )

    def not_revolved(self) -> Results:
        """Return the results of Geometry 2 with a prismatic wheel."""
        name, changes = "geometry2, not revolved", {"upper": {"rolling_radius": float("inf")}}
        return self._solve(name, lambda: replace(self._scene("geometry2", changes), name=name))

    def plane(self) -> Results:
        """Return the results of two half-spaces."""
        return self._solve("flat", lambda: self._scene("flat"))

    def nearly_plane(self) -> Results:
        """Return the results of Geometry 1 with arcs of a very large radius."""
        arc = {"contour": {"kind": "arc", "radius": NEARLY_PLANE, "flank_inclination_deg": 25.5}}
        changes = {"lower": arc, "upper": arc, "reference_length": 10.0}
        name = f"arcs of {NEARLY_PLANE / 1000:g} m"
        return self._solve(name, lambda: replace(self._scene("geometry1", changes), name=name))

    def fe_contact(self, contacts: Contacts) -> xr.Dataset:
        """Return numbers of contacts with ICs and by finite elements."""

        def solve() -> xr.Dataset:
            changes = {"loads": list(contacts.loads), "shift": contacts.shift}
            scene = load_scene(contacts.scene, {"contact": changes})
            with_ics = compute_contact(scene, self.options)
            return compute_fe_contact(scene, with_ics, self.options, contacts.cells)

        loads = ", ".join(f"{load / 1e3:g}" for load in contacts.loads)
        case = f"{contacts.scene}, {loads} kN, shift {contacts.shift:g} mm"
        return self.once(f"{case}: contact with ICs and by finite elements", solve)

    def contact(self, name: str, changes: Mapping[str, Any]) -> xr.Dataset:
        """Return numbers of the contacts of a scene with some keys of [contact] changed."""
        return self.once(
            f"contact of {name}, {dict(changes)}",
            lambda: compute_contact(load_scene(name, {"contact": dict(changes)}), self.options),
        )

    def contact_series(self, name: str) -> ContactSeries:
        """Return the frictionless contacts of a scene under any load with A, B, B-hat and C."""
        return self.once(
            f"contacts of {name}",
            lambda: ContactSeries(
                self._contact_scene(name).contact_problem, self.options, SERIES_LOADS[name]
            ),
        )

    def friction(
        self, name: str, changes: Mapping[str, Any], given: Mapping[str, GivenICs] = NONE_GIVEN
    ) -> xr.Dataset:
        """Return numbers and maps of the contacts with friction of a scene with some keys changed.

        `given` are ICs by the names under which the scene asks for them.
        """
        return self.once(
            f"contact with friction of {name}, {dict(changes)}",
            lambda: compute_with_friction(load_scene(name, dict(changes)), self.options, given),
        )

    def once(self, name: str, compute: Callable[[], Value], known: dict[str, Value] | None = None) -> Value:
        """Return what has a name, computed when it is first used."""
        memory = self.known if known is None else known
        if name not in memory:
            self.options.watch.on_stage(f"  {name}")
            memory[name] = compute()
        value: Value = memory[name]
        return value

    def _scene(self, name: str, changes: Mapping[str, Any] | None = None, *, check: bool = False) -> Scene:
        engine = {"tolerance": self.tolerance, "check": check}
        variants = [variant for variant in VARIANTS if variant != "Bhat_prime"]
        defaults = {"components": list(COMPONENTS), "variants": variants, "engine": engine}
        return load_scene(name, defaults | dict(changes or {}))

    def _contact_scene(self, name: str) -> Scene:
        return load_scene(name)

    def _fit(self, name: str) -> Mapping[str, EffectiveProperties]:
        """Return effective properties of a geometry, fitted to C_xn of one load position."""
        return calibrate(self._scene(name), self.options).scene.effective

    def _solve(self, name: str, make_scene: Callable[[], Scene]) -> Results:
        return self.once(name, lambda: compute(make_scene(), self.options), self.done)


def solved_once(name: str) -> Callable[[Callable[[Runs], Value]], Callable[[Runs], Value]]:
    """Make what a function solves a result of the runs, by a name: it is solved when it is first used."""

    def decorate(solve: Callable[[Runs], Value]) -> Callable[[Runs], Value]:
        return wraps(solve)(lambda runs: runs.once(name, lambda: solve(runs)))

    return decorate
