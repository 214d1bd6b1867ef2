"""Contact of a pair with any ICs: without friction, in steady or transient rolling, and in compression."""

from collections.abc import Sequence
from dataclasses import asdict, dataclass, replace
from typing import Any, ClassVar, Literal

import numpy as np
import xarray as xr
from numpy.typing import ArrayLike

from femic.contact.pairs.ics import GivenICs
from femic.contact.specification import ExtraGap, FrictionSpecification, extra_gap
from femic.interface.arguments import array, check_fields, with_checked_arguments
from femic.interface.bodies import Pair, checked, given
from femic.interface.matrices import matrix_grid, matrix_name, ordered
from femic.interface.options import DEFAULT, Options, in_turn, make_scene
from femic.results.contact import compute_contact
from femic.results.friction import compute_with_friction
from femic.scenes.contact import ContactTable, contact_specification
from femic.scenes.scene import Scene
from geometries.errors import WrongInput
from geometries.patches import Grid

ICs = str | xr.Dataset


@dataclass(frozen=True)
class _MotionKeys:
    """A motion whose fields are keys of a scene file; a single `load` is the only one of its `loads`."""

    kind: ClassVar[str]

    def __post_init__(self) -> None:
        check_fields(self)
        names = {("loads", 0): "load"} if hasattr(self, "load") else {}
        if np.ndim(getattr(self, "friction", ())) == 0:
            names[("friction", 0)] = "friction"
        checked(ContactTable, self.keys, names)

    @property
    def keys(self) -> dict[str, Any]:
        """The keys of [contact] in a scene."""
        keys = given(vars(self) | {"motion": self.kind})
        if "load" in keys:
            keys["loads"] = [keys.pop("load")]
        if "friction" in keys:
            keys["friction"] = np.atleast_1d(keys["friction"])
        return keys


@dataclass(frozen=True)
class Frictionless(_MotionKeys):
    """Contact without friction, under vertical `loads` [N] or at vertical `approaches` [mm].

    If you give a `lateral_force` [N] on the upper body, femic finds its lateral position. Raises WrongInput.
    """

    kind = "none"

    loads: Sequence[float] = ()
    approaches: Sequence[float] = ()
    lateral_force: float | None = None


@dataclass(frozen=True)
class Rolling(_MotionKeys):
    """Steady rolling of the upper body towards +x under a vertical `load` [N], at coefficients of `friction`.

    Contacts are solved at all `longitudinal` creepages, omega R / V - 1 (1), and at the creepage where the
    longitudinal force is `equal_force` times friction times load. `lateral` is the lateral velocity of the
    wheel divided by V (1), `spin` its angular velocity about z divided by V [1/mm]. Friction may depend on
    the contact angle: `friction_by_angle` holds pairs of an angle [degrees] and a factor for the
    coefficients, linear between the angles. Raises WrongInput.
    """

    kind = "rolling"

    load: float
    friction: float | Sequence[float]
    longitudinal: Sequence[float] = FrictionSpecification.longitudinal
    lateral: float = 0.0
    spin: float = 0.0
    equal_force: float = 0.5
    friction_by_angle: Sequence[tuple[float, float]] = ()


@dataclass(frozen=True)
class TransientRolling(_MotionKeys):
    """Rolling of the upper body from rest at constant creepages, in steps of one element.

    `creepage`, `lateral`, `spin` and `friction_by_angle` have the meaning they have in `Rolling`. `distance`
    [mm] is the rolled distance, by default three patch lengths. Raises WrongInput.
    """

    kind = "transient"

    load: float
    friction: float | Sequence[float]
    creepage: float = FrictionSpecification.creepage
    lateral: float = 0.0
    spin: float = 0.0
    distance: float | None = None
    friction_by_angle: Sequence[tuple[float, float]] = ()


@dataclass(frozen=True)
class Compression(_MotionKeys):
    """Compression with friction: bodies pressed together under increasing vertical `loads` [N].

    `friction_by_angle` has the meaning it has in `Rolling`. Raises WrongInput.
    """

    kind = "compression"

    loads: Sequence[float]
    friction: float | Sequence[float]
    friction_by_angle: Sequence[tuple[float, float]] = ()


@dataclass(frozen=True, eq=False)
class ContactSetup:
    """Position of the bodies, distance between them, and elements.

    Give the number of `elements` across the smallest patch, and femic fits the grid to the contact; or give a
    `grid` about x = 0. `shift` [mm] moves the upper body along y. With `flanks` false, the bodies do not
    touch on the straight flanks. The undeformed distance `gap` is "linear" or, without friction only,
    "exact": the distance of the displaced body. `extra_gap` (n, 2 or 3) adds a gap, with columns s, gap or x,
    s, gap [mm].
    """

    elements: int = 20
    grid: Grid | None = None
    shift: float = 0.0
    flanks: bool = True
    gap: Literal["linear", "exact"] = "linear"
    extra_gap: ArrayLike | None = None

    def __post_init__(self) -> None:
        check_fields(self)
        checked(ContactTable, self.keys)
        _ = self.added_gap  # raises for points that have no gap between them

    @property
    def added_gap(self) -> ExtraGap | None:
        """The gap that is added. Raises WrongInput."""
        if self.extra_gap is None:
            return None
        columns = array("extra_gap", self.extra_gap)
        if columns.ndim != 2 or columns.shape[1] not in (2, 3):
            raise WrongInput(
                f"extra_gap of shape {columns.shape}: (n, 2) or (n, 3) is needed: s, gap or x, s, gap"
            )
        try:
            return extra_gap(columns)
        except WrongInput as error:
            raise WrongInput(f"extra_gap: {error}") from error

    @property
    def keys(self) -> dict[str, Any]:
        """The keys of [contact] in a scene."""
        keys = {"elements": self.elements, "shift": self.shift, "flanks": self.flanks}
        gap = None if self.gap == "linear" else self.gap  # a key of contact without friction
        return given({**keys, "gap": gap, "grid": self.grid and "scene"})


AUTOMATIC = ContactSetup()
Motion = Frictionless | Rolling | TransientRolling | Compression


@with_checked_arguments
@in_turn
def solve_contact(
    pair: Pair,
    motion: Motion,
    ics: Sequence[ICs] = ("A", "Bhat", "C"),
    setup: ContactSetup = AUTOMATIC,
    options: Options = DEFAULT,
) -> xr.Dataset:
    """Solve the contact of a pair with each of several ICs.

    `ics` lists names of approximations, "C" (computed on the grid of the contact), and matrices from
    `compute_matrix` or `label_matrix`. With a matrix, all contacts are solved on its grid. Matrices are read
    by their labels, in any order.

    The dataset holds forces, moments, approach, p_max and other numbers, with units and meanings, and for
    each its estimated error `estimate_NAME`. Without friction its dimensions are ics and `case`, the
    prescribed loads [N] or approaches [mm]; with friction they are ics, friction and `xi` (creepage),
    `distance` or `load`. Without friction, pressures `p` [MPa] have the dimensions case, ics, x and s; each
    case has a separate grid with coordinates `x` and `s` [mm], and is NaN beyond it. With friction, the
    tractions `p` on the upper body over x, s and direction [MPa], `stick` and `slip` belong to `equal_force`,
    to the end of the distance, or to the last load.

    Raises WrongInput; raises Failure if there is no solution, or if C does not reach the tolerance.
    """
    scene, own = described(pair, motion, ics, setup, options)
    if scene.contact.friction:
        return compute_with_friction(scene, options.run, own)
    return compute_contact(scene, options.run, own)


def described(
    pair: Pair, motion: Motion, ics: Sequence[ICs], setup: ContactSetup, options: Options
) -> tuple[Scene, dict[str, GivenICs]]:
    """Return the scene of a contact, and the ICs that are given, by name. Raises WrongInput."""
    names = tuple(each if isinstance(each, str) else matrix_name(each) for each in ics)
    if len(set(names)) < len(names):
        raise WrongInput(f"ics: {', '.join(names)}: two have the same name: name each once")
    matrices = {name: each for name, each in zip(names, ics, strict=True) if isinstance(each, xr.Dataset)}
    named = tuple(name for name in names if name not in matrices)
    table = checked(ContactTable, setup.keys | motion.keys | ({"ics": named} if named else {}))
    contact = replace(contact_specification(table), ics=named, extra_gap=setup.added_gap)
    keys = given({"contact": table, "grid": setup.grid and asdict(setup.grid)})
    scene = make_scene(pair, options, keys, contact=contact)
    scene = replace(scene, contact=replace(contact, ics=names))
    own = {}
    for name, labelled in matrices.items():
        matrix = ordered("ics", labelled)
        estimate = matrix.estimate.values if "estimate" in matrix else 0.0
        own[name] = GivenICs(matrix_grid(matrix), matrix.ic.values, estimate)
    return scene, own
