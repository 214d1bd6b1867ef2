"""The runs that statements need, each computed when it is first used."""

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field, replace
from typing import Any, TypeVar

import xarray as xr

from approx.effective import EffectiveProperties
from approx.variants import VARIANTS
from compare.validation.estimates import GridComparison, stored_comparisons
from compare.validation.statements.contact_series import ContactSeries
from femic.contact.finite_elements.fineness import CELLS
from femic.contact.pairs.ics import NONE_GIVEN, GivenICs
from femic.reference.run_options import RunOptions
from femic.results.calibration import calibrate
from femic.results.contact import compute_contact, to_dataset
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
    done: dict[str, Results] = field(default_factory=dict)
    contacts: dict[str, xr.Dataset] = field(default_factory=dict)
    series: dict[str, ContactSeries] = field(default_factory=dict)
    others: dict[str, Any] = field(default_factory=dict)  # by name, of single statements
    comparisons: dict[tuple[str, int, int], list[GridComparison]] = field(default_factory=dict)

    def geometry(self, name: str) -> Results:
        """Return the results of a geometry of the source [BVSV]."""
        return self._once(name, lambda: self._compute(self._scene(name)))

    def fitted(self, name: str) -> Results:
        """Return the results of a geometry with B-hat-prime, fitted to the same geometry."""
        return self._once(f"{name}, fitted", lambda: self._with_fit(self.geometry(name)))

    def with_both_engines(self, name: str) -> Results:
        """Return the results of a geometry with C of both engines."""
        return self._once(f"{name}, both engines", lambda: self._compute(self._scene(name, check=True)))

    def other_nu(self, name: str) -> Results:
        """Return the results of a geometry with the Poisson's ratio of the other geometry."""
        nu = {"nu": OTHER_NU[name]}
        return self._once(
            f"{name}, nu = {OTHER_NU[name]:.2f}",
            lambda: self._compute(self._scene(name, {"lower": nu, "upper": nu})),
        )

    def not_revolved(self) -> Results:
        """Return the results of Geometry 2 with a prismatic wheel."""
        prismatic = {"upper": {"rolling_radius": float("inf")}}
        name = "geometry2, not revolved"
        return self._once(
            name, lambda: self._compute(replace(self._scene("geometry2", prismatic), name=name))
        )

    def plane(self) -> Results:
        """Return the results of two half-spaces."""
        return self._once("flat", lambda: self._compute(self._scene("flat")))

    def nearly_plane(self) -> Results:
        """Return the results of Geometry 1 with arcs of a very large radius."""
        arc = {"contour": {"kind": "arc", "radius": NEARLY_PLANE, "flank_inclination_deg": 25.5}}
        changes = {"lower": arc, "upper": arc, "reference_length": 10.0}
        name = f"arcs of {NEARLY_PLANE / 1000:g} m"
        return self._once(name, lambda: self._compute(replace(self._scene("geometry1", changes), name=name)))

    def fe_contact(self, contacts: Contacts) -> xr.Dataset:
        """Return numbers of contacts with ICs and by finite elements."""
        loads = ", ".join(f"{load / 1e3:g}" for load in contacts.loads)
        key = f"{contacts.scene}, {loads} kN, shift {contacts.shift:g} mm"
        if key not in self.contacts:
            self.options.watch.on_stage(f"  {key}: contact with ICs and by finite elements")
            changes = {"loads": list(contacts.loads), "shift": contacts.shift}
            scene = load_scene(contacts.scene, {"contact": changes})
            with_ics = to_dataset(compute_contact(scene, self.options))
            self.contacts[key] = compute_fe_contact(scene, with_ics, self.options, contacts.cells)
        return self.contacts[key]

    def contact(self, name: str, changes: Mapping[str, Any]) -> xr.Dataset:
        """Return numbers of the contacts of a scene with some keys of [contact] changed."""
        key = f"{name}, {dict(changes)}"
        if key not in self.contacts:
            self.options.watch.on_stage(f"  contact of {key}")
            scene = load_scene(name, {"contact": dict(changes)})
            self.contacts[key] = to_dataset(compute_contact(scene, self.options))
        return self.contacts[key]

    def contact_series(self, name: str) -> ContactSeries:
        """Return the frictionless contacts of a scene under any load with A, B, B-hat and C."""
        if name not in self.series:
            problem = self._contact_scene(name).contact_problem
            self.series[name] = ContactSeries(problem, self.options, SERIES_LOADS[name])
        return self.series[name]

    def friction(
        self, name: str, changes: Mapping[str, Any], given: Mapping[str, GivenICs] = NONE_GIVEN
    ) -> xr.Dataset:
        """Return numbers and maps of the contacts with friction of a scene with some keys changed.

        `given` are ICs by the names under which the scene asks for them.
        """
        key = f"{name}, {dict(changes)}"
        if key not in self.contacts:
            self.options.watch.on_stage(f"  contact with friction of {key}")
            self.contacts[key] = compute_with_friction(load_scene(name, dict(changes)), self.options, given)
        return self.contacts[key]

    def random_contacts(self, study: str, seed: int, count: int) -> list[GridComparison]:
        """Return random contacts of a study on grids of three fineness levels."""
        key = study, seed, count
        if key not in self.comparisons:
            self.comparisons[key] = stored_comparisons(study, seed, count, self.options)
        return self.comparisons[key]

    def remembered(self, name: str, compute: Callable[["Runs"], Value]) -> Value:
        """Return what a statement computes from these runs by itself, computed when it is first used."""
        if name not in self.others:
            self.options.watch.on_stage(f"  {name}")
            self.others[name] = compute(self)
        value: Value = self.others[name]
        return value

    def _once(self, name: str, make: Callable[[], Results]) -> Results:
        if name not in self.done:
            self.options.watch.on_stage(f"  {name}")
            self.done[name] = make()
        return self.done[name]

    def _scene(self, name: str, changes: Mapping[str, Any] | None = None, *, check: bool = False) -> Scene:
        engine = {"tolerance": self.tolerance, "check": check}
        variants = [variant for variant in VARIANTS if variant != "Bhat_prime"]
        defaults = {"components": list(COMPONENTS), "variants": variants, "engine": engine}
        return load_scene(name, defaults | dict(changes or {}))

    def _contact_scene(self, name: str) -> Scene:
        return load_scene(name)

    def _with_fit(self, results: Results) -> Results:
        fit = self._fit(results.scene.name)
        return with_approximations(results, replace(results.scene, effective=fit, variants=tuple(VARIANTS)))

    def _fit(self, name: str) -> Mapping[str, EffectiveProperties]:
        """Return effective properties of a geometry, fitted to C_xn of one load position."""
        return calibrate(self._scene(name), self.options).scene.effective

    def _compute(self, scene: Scene) -> Results:
        return compute(scene, self.options)
