"""Contacts on call: a pair on a grid, kept with its ICs, solved again and again in milliseconds."""

from collections.abc import Mapping
from dataclasses import dataclass, replace
from functools import cached_property
from types import MappingProxyType

import numpy as np
import xarray as xr
from numpy.typing import ArrayLike

from femic.contact.friction.motion import NAMES, Creepages
from femic.contact.frictional import FrictionalContact
from femic.contact.loading import Loading
from femic.contact.motions import pair_in_motion
from femic.contact.normal import NormalContact, NormalProblem
from femic.contact.normal import solve as solve_frictionless
from femic.contact.pairs import grids
from femic.contact.pairs.ics import select_given
from femic.contact.pairs.pair_on_grid import PairOnGrid, pair_on_grid
from femic.contact.patch import Resultant
from femic.contact.rolling import RollingContact, RollingProblem
from femic.interface.arguments import array, with_checked_arguments
from femic.interface.bodies import Pair
from femic.interface.contact import AUTOMATIC, ContactSetup, ICs, Rolling, described
from femic.interface.options import DEFAULT, LOCK, Options
from femic.results.contact import require_solvable
from geometries.arrays import Array, Mask
from geometries.errors import WrongInput
from geometries.patches import DIRECTIONS, Grid, N

NO_FORCES: Mapping[str, float] = MappingProxyType({})
COLUMNS = {  # of `solve_many`: unit and meaning
    "F_x": ("N", "longitudinal force on the upper body"),
    "F_y": ("N", "lateral force on the upper body"),
    "F_z": ("N", "vertical force on the upper body"),
    "M_x": ("N mm", "moment on the upper body about x"),
    "M_y": ("N mm", "moment on the upper body about y"),
    "M_z": ("N mm", "moment on the upper body about z"),
    "p_max": ("MPa", "largest pressure"),
    "approach": ("mm", "vertical approach"),
    "area": ("mm2", "contact area"),
    "sliding_share": ("1", "sliding area over contact area"),
    "work": ("N", "work of friction per unit of rolled distance"),
}


@dataclass(frozen=True, eq=False)
class SolvedContact:
    """One contact on its grid; forces [N], moments and tractions [MPa] are those on the upper body.

    `creepages` are those at which it rolls. Moments [N mm] are about the contact centre.
    """

    on_grid: PairOnGrid
    contact: NormalContact | FrictionalContact
    creepages: Creepages

    @property
    def x(self) -> Array:
        """Centres of elements along x [mm], shape (n_x,)."""
        return self.on_grid.x

    @property
    def s(self) -> Array:
        """Arc lengths of the centres of strips [mm], shape (n_s,)."""
        return self.on_grid.grid.strips

    @property
    def tractions(self) -> Array:
        """Tractions along x, s, n of the lower surface [MPa], shape (n_x, n_s, 3)."""
        return self.contact.tractions

    @property
    def pressures(self) -> Array:
        """Pressures [MPa], shape (n_x, n_s)."""
        return self.contact.pressures

    @property
    def slip(self) -> Array:
        """Slip of the upper over the lower surface per unit of rolled distance, shape (n_x, n_s, 2)."""
        if isinstance(self.contact, FrictionalContact):
            return self.contact.slip
        return np.zeros((*self.pressures.shape, N))

    @property
    def stick(self) -> Mask:
        """Which elements stick, shape (n_x, n_s)."""
        if isinstance(self.contact, FrictionalContact):
            return self.contact.stick
        return np.zeros(self.pressures.shape, bool)

    @property
    def work_density(self) -> Array:
        """Work of friction per area and unit of rolled distance [MPa], shape (n_x, n_s)."""
        if isinstance(self.contact, FrictionalContact):
            return self.contact.dissipation
        return np.zeros(self.pressures.shape)

    @property
    def approach(self) -> float:
        """Vertical approach [mm]."""
        return self.contact.approach

    @property
    def force(self) -> Array:
        """Force along x, y, z [N], shape (3,)."""
        return self._resultant.force

    @property
    def moment(self) -> Array:
        """Moment about x, y, z through the contact centre [N mm], shape (3,)."""
        return self._resultant.moment

    @cached_property
    def _resultant(self) -> Resultant:
        return self.on_grid.resultant(self.tractions)

    @property
    def numbers(self) -> dict[str, float]:
        """Forces, moments, largest pressure, approach, area, sliding share and work, as in `solve_many`."""
        is_frictional = isinstance(self.contact, FrictionalContact)
        values = (
            *self.force,
            *self.moment,
            np.max(self.pressures),
            self.approach,
            self.contact.area,
            self.contact.sliding_share if isinstance(self.contact, FrictionalContact) else 0.0,
            np.sum(self.work_density) * self.on_grid.grid.area if is_frictional else 0.0,
        )
        return {name: float(value) for name, value in zip(COLUMNS, values, strict=True)}

    def to_dataset(self) -> xr.Dataset:
        """Return all of it with labels, units and meanings."""
        places = "x", "s"
        return xr.Dataset(
            {
                "p": (
                    (*places, "direction"),
                    self.tractions,
                    {"units": "MPa", "long_name": "traction on the upper body"},
                ),
                "slip": ((*places, "tangential"), self.slip, {"units": "1", "long_name": "slip"}),
                "stick": (places, self.stick, {"long_name": "whether the element sticks"}),
                **{
                    name: ((), value, {"units": COLUMNS[name][0], "long_name": COLUMNS[name][1]})
                    for name, value in self.numbers.items()
                },
            },
            coords={
                "x": ("x", self.x, {"units": "mm", "long_name": "place along the direction of rolling"}),
                "s": ("s", self.s, {"units": "mm", "long_name": "arc length of the lower contour"}),
                "direction": list(DIRECTIONS),
                "tangential": list(DIRECTIONS[:N]),
            },
            attrs={name: getattr(self.creepages, name) for name in NAMES},
        )


class ContactSolver:
    """A pair on a grid with its ICs, kept to solve many contacts.

    The grid fits the contact under `load` [N], the largest that you are going to ask for, with
    `setup.elements` across its patch; or give `setup.grid`. `ics` is the name of an approximation, "C"
    (computed now), or a matrix from `compute_matrix` or `label_matrix`. Each solution begins with the last
    one; its tractions are found to 1e-6 of the largest pressure. Errors of elements and ICs are not
    estimated: `solve_contact` does that.

    Several threads may use the same solver. Raises WrongInput; raises Failure as `solve_contact`.
    """

    @with_checked_arguments
    def __init__(
        self,
        pair: Pair,
        load: float,
        ics: ICs = "Bhat",
        setup: ContactSetup = AUTOMATIC,
        options: Options = DEFAULT,
    ) -> None:
        with LOCK:
            motion = Rolling(load=load, friction=0.3, longitudinal=(-1e-3, 0.0, 1e-3))
            scene, own = described(pair, motion, [ics], setup, options)
            require_solvable(scene, own)
            problem, (name,) = scene.contact_problem, scene.contact.ics
            chosen = select_given(problem.specification.ics, own)
            ((grid, _),) = grids.grids_of(problem, chosen)
            in_motion = pair_in_motion(problem, pair_on_grid(problem, grid), options.run, own)
            operator = in_motion.operator(name)
            self._on_grid = in_motion.on_grid
            self._rolling: RollingProblem = in_motion.rolling(in_motion.frictional(operator, 0.3))
        self._normal = self._rolling.problem.normal
        self._last: FrictionalContact | None = None
        self._last_pressures: Array | None = None

    @property
    def grid(self) -> Grid:
        """The grid, about x = 0."""
        return self._on_grid.grid

    @with_checked_arguments
    def solve(
        self,
        load: float | None = None,
        *,
        approach: float | None = None,
        friction: float = 0.0,
        longitudinal: float = 0.0,
        lateral: float = 0.0,
        spin: float = 0.0,
        forces: Mapping[str, float] = NO_FORCES,
        extra_gap: ArrayLike | None = None,
    ) -> SolvedContact:
        """Return the contact under a vertical `load` [N] or at an `approach` [mm].

        With `friction`, the wheel rolls at creepages `longitudinal`, `lateral` (1) and `spin` [1/mm], as in
        `Rolling`. If you give `forces` on the upper body by the names of creepages (longitudinal: F_x [N],
        lateral: F_y [N], spin: M_z [N mm]), these creepages follow from them. `extra_gap` [mm], of shape
        (n_x, n_s) or (n_s,) on the grid, is added to the distance of the bodies, for example by wear.

        Raises WrongInput; raises Failure if there is no solution, or if the contact reaches the end of the
        grid.
        """
        distance = self._on_grid.distance
        if extra_gap is not None:
            distance = distance + self._gap(extra_gap)
        creepages = Creepages(longitudinal, lateral, spin)
        return self._solve(Loading(load, approach), distance, friction, creepages, forces)

    def solve_many(self, **given: ArrayLike) -> xr.Dataset:
        """Return the numbers of many contacts. Arguments are those of `solve`, as numbers or arrays.

        All but `forces` and `extra_gap` may be given. Arrays are broadcast against each other. Contacts are
        solved in their order, each from the one before, so neighbours should be alike. The dimensions of the
        dataset are those of the arrays: `case`, or `case_0`, `case_1`, ... if there are several.

        Raises as `solve`.
        """
        unknown = set(given) - {"load", "approach", "friction", "longitudinal", "lateral", "spin"}
        if unknown:
            raise WrongInput(f"{', '.join(sorted(unknown))}: not an argument of solve_many")
        if not {"load", "approach"} & set(given):
            raise WrongInput("solve_many: give loads or approaches")
        separate = [array(name, values) for name, values in given.items()]
        try:
            arrays = np.broadcast_arrays(*separate)
        except ValueError as error:
            shapes = ", ".join(f"{name} {each.shape}" for name, each in zip(given, separate, strict=True))
            raise WrongInput(f"{shapes}: these shapes cannot be broadcast against each other") from error
        shape = arrays[0].shape
        rows = []
        for values in zip(*(each.ravel().tolist() for each in arrays), strict=True):
            case = dict(zip(given, values, strict=True))
            loading = Loading(case.get("load"), case.get("approach"))
            creepages = Creepages(**{name: case.get(name, 0.0) for name in NAMES})
            friction = case.get("friction", 0.0)
            rows.append(self._solve(loading, self._on_grid.distance, friction, creepages, NO_FORCES).numbers)
        dims = ("case",) if len(shape) == 1 else tuple(f"case_{axis}" for axis in range(len(shape)))
        return xr.Dataset(
            {
                name: (
                    dims,
                    np.reshape([row[name] for row in rows], shape),
                    {"units": unit, "long_name": meaning},
                )
                for name, (unit, meaning) in COLUMNS.items()
            },
            coords={name: (dims, values) for name, values in zip(given, arrays, strict=True)},
        )

    def _gap(self, extra_gap: ArrayLike) -> Array:
        gap, shape = array("extra_gap", extra_gap), self._on_grid.distance.shape
        if gap.shape not in (shape, shape[1:]):
            raise WrongInput(f"extra_gap of shape {gap.shape}: {shape} or {shape[1:]} is needed, as the grid")
        return gap

    def _solve(
        self,
        loading: Loading,
        distance: Array,
        friction: float,
        creepages: Creepages,
        forces: Mapping[str, float],
    ) -> SolvedContact:
        """Return the contact; the problem is read once, as another thread may put its own in its place."""
        if friction == 0 and not forces:
            return self._without_friction(loading, distance, creepages)
        rolling = self._rolling
        problem = rolling.problem
        if friction != problem.friction or distance is not problem.distance:
            rolling = replace(rolling, problem=replace(problem, friction=friction, distance=distance))
            self._rolling = rolling  # the next one is likely to be alike
        solved: RollingContact = rolling.contact(creepages, loading, forces=forces, start=self._last)
        self._last = solved.contact
        return SolvedContact(self._on_grid, solved.contact, solved.creepages)

    def _without_friction(self, loading: Loading, distance: Array, creepages: Creepages) -> SolvedContact:
        problem = self._normal
        if distance is not self._on_grid.distance:
            problem = NormalProblem(problem.grid, problem.operator, problem.flat, distance, problem.cosine)
        contact = solve_frictionless(
            problem, load=loading.load, approach=loading.approach, start=self._last_pressures
        )
        self._last_pressures = contact.p
        return SolvedContact(self._on_grid, contact, creepages)
