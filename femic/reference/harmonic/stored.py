"""Stored models of the harmonic engine: for E = 1 MPa, as entries of the store, and which serve a request.

Models are solved and stored for a Young's modulus of 1 MPa, because displacements are proportional to 1/E:
bodies that differ only in E share a model. An entry of the store (`femic.cache.store`) has the responses; an
unfinished one consists of parts, one per wavenumber.

A request is served by its own model, or by one whose strips make up the requested strips: a load on a strip
is the mean of loads on the equal strips that it consists of. So a model serves grids of fewer strips, of
wider strips whose centres it observes, of other element lengths, and grids shifted by whole strips. The store
has an index of the models of each body.
"""

import json
from collections.abc import Sequence
from dataclasses import asdict, dataclass, replace

import numpy as np
import xarray as xr

from femic.cache.store import Store
from femic.reference.engine import cost_from
from femic.reference.harmonic.request import SCALE_LOWEST, HarmonicRequest
from femic.reference.harmonic.synthesis import Responses
from femic.reference.harmonic.waves import Axis, Samples
from femic.reference.meshing import Cells
from geometries.arrays import Array, Indices
from geometries.bodies import Body, Domain
from geometries.patches import DIRECTIONS, Load, Patch

# --- E = 1 MPa ---

UNIT = 1.0  # MPa
DIGITS = 9  # significant digits of an accuracy: it differs by rounding between bodies with different E


def with_unit_modulus(request: HarmonicRequest) -> HarmonicRequest:
    """Return the request for the same body with E = 1 MPa, its accuracy rounded to `DIGITS`."""
    body = request.body
    accuracy = np.asarray(request.accuracy * (body.material.E / UNIT), dtype=float)
    scale = 10.0 ** (DIGITS - 1 - np.floor(np.log10(accuracy)))
    unit = replace(body, material=replace(body.material, E=UNIT))
    return replace(request, body=unit, accuracy=np.round(accuracy * scale) / scale)


# --- entries of the store ---

WaveSolution = tuple[Array, float]  # responses (arc, load, 3, len(s)) [mm^2/N] and their residual


def to_entry(responses: Responses) -> xr.Dataset:
    """Return the entry of responses; with the nearer far arc only the responses that differ."""
    samples = responses.samples
    differs = np.any(samples.responses[:, 0] != samples.responses[:, 1], axis=(1, 2, 3))
    dims = ("load", "i", "point")
    return xr.Dataset(
        {
            "response": (("k", *dims), samples.responses[:, 0], {"units": "mm2/N"}),
            "response_nearer": (("k_felt", *dims), samples.responses[differs, 1], {"units": "mm2/N"}),
            "response_coarser": (("k_sparser", *dims), responses.coarser, {"units": "mm2/N"}),
            "last": ("k", samples.last),
            "vertices": (("yz", "vertex"), responses.drawn[0], {"units": "mm"}),
            "triangles": (("corner", "triangle"), responses.drawn[1]),
        },
        coords={
            "k": ("k", samples.k, {"units": "1/mm"}),
            "k_felt": ("k_felt", samples.k[differs], {"units": "1/mm"}),
            "k_sparser": ("k_sparser", samples.sparser.k, {"units": "1/mm"}),
            "s": ("point", responses.s, {"units": "mm"}),
            "load_s": ("load", [load.patch.s for load in responses.loads], {"units": "mm"}),
            "load_b": ("load", [load.patch.b for load in responses.loads], {"units": "mm"}),
            "load_direction": ("load", [DIRECTIONS[load.direction] for load in responses.loads]),
            "i": list(DIRECTIONS),
        },
        attrs={
            "title": "displacements of a section under unit line loads that vary as cos(k x) or sin(k x)",
            "cost": json.dumps(asdict(responses.cost)),
        },
    )


@dataclass(frozen=True)
class StoredWaves:
    """The solved wavenumbers of an unfinished entry, by name."""

    store: Store
    key: str

    def get(self, name: str) -> WaveSolution | None:
        """Return the responses and their residual, None if they are not stored."""
        part = self.store.part(self.key, name)
        return None if part is None else (part["responses"], float(part["residual"]))

    def put(self, name: str, solution: WaveSolution) -> None:
        """Store the responses and their residual."""
        responses, residual = solution
        self.store.put_part(self.key, name, {"responses": responses, "residual": np.array(residual)})


NOT_STORED = StoredWaves(Store(), "")


# --- models that serve a request ---

SAME_PLACE = 1e-6  # of the half-width of a strip: arc lengths that are closer are the same
AS_ACCURATE = 1.1  # factor by which the wavenumbers of a model may be less accurate than requested
ROUNDING = 1 + 1e-9  # factor by which equal numbers may differ


def model_key(request: HarmonicRequest, store: Store) -> str:
    """Return the key of the model of a request in the store, which is independent of E."""
    return store.key("harmonic", *with_unit_modulus(request).determined_by)


def stored_model(request: HarmonicRequest, store: Store) -> Responses | None:
    """Return the requested responses from a stored model of any E, None if there is none."""
    unit = with_unit_modulus(request)
    own, entry = ModelOutline.describe(unit), store.get(model_key(unit, store))
    if entry is not None:
        return requested_part(own.read(entry, unit.body), request)
    if not unit.on_strips:
        return None
    index = _index_key(unit, store)
    stored = {key: store.part(index, key) for key in store.part_names(index)}
    outlines = {key: ModelOutline(**arrays) for key, arrays in stored.items() if arrays is not None}
    for key in sorted(outlines, key=lambda key: (len(outlines[key].strips), key)):  # small models first
        if outlines[key].serves(unit) and (entry := store.get(key)) is not None:
            return requested_part(outlines[key].read(entry, unit.body), request)
    return None


def store_model(responses: Responses, request: HarmonicRequest, store: Store) -> None:
    """Store the responses to a request with E = 1 MPa, and their outline in the index of the body."""
    key = model_key(request, store)
    store.put(key, to_entry(responses))
    if request.on_strips:
        store.put_part(_index_key(request, store), key, asdict(ModelOutline.describe(request)))


def requested_part(solved: Responses, request: HarmonicRequest) -> Responses:
    """Return the requested responses, with the E of the request, of a model for E = 1 MPa that serves it."""
    members = [_members(solved.loads, load) for load in request.requested_loads]
    s, factor = request.requested_s, UNIT / request.body.material.E
    places = np.argmin(np.abs(solved.s[:, None] - s), axis=0)

    def part(responses: Array) -> Array:
        means = [np.mean(responses[..., numbers, :, :], axis=-3) for numbers in members]
        return factor * np.stack(means, axis=-3)[..., places]

    return replace(
        solved,
        body=replace(solved.body, material=request.body.material),
        loads=request.requested_loads,
        s=s,
        samples=replace(solved.samples, responses=part(solved.samples.responses)),
        coarser=part(solved.coarser),
    )


def _index_key(request: HarmonicRequest, store: Store) -> str:
    """Return the key of the index of all models of a body in any domain."""
    return store.key("harmonic-models", replace(request.body, domain=Domain(1.0, np.inf)))


@dataclass(frozen=True, eq=False)
class ModelOutline:
    """The loads, observers, wavenumbers and cells of a stored model; lengths in mm."""

    far_radius: Array  # ()
    k_max: Array  # () [1/mm]
    accuracy: Array  # (), least one of the interpolation between wavenumbers [mm/N]
    cells: Array  # smallest, growth, line_growth
    strips: Array  # half-sides a, b and centre s of each load, (n, 3)
    directions: Array  # (n,)
    s: Array  # (m,)

    @classmethod
    def describe(cls, request: HarmonicRequest) -> "ModelOutline":
        """Describe the model of a request."""
        cells = request.cells
        return cls(
            np.array(request.body.domain.far_radius),
            np.array(request.k_max),
            np.asarray(np.min(request.accuracy)),
            np.array([cells.smallest, cells.growth, cells.line_growth]),
            np.array([[load.patch.a, load.patch.b, load.patch.s] for load in request.loads]),
            np.array([load.direction for load in request.loads], dtype=float),
            request.observed,
        )

    @property
    def loads(self) -> tuple[Load, ...]:
        """The loads."""
        return tuple(
            Load(Patch(*strip), int(direction))
            for strip, direction in zip(self.strips.tolist(), self.directions, strict=True)
        )

    def read(self, entry: xr.Dataset, body: Body) -> Responses:
        """Return the responses of a body, in the domain of the model, from the entry of the model."""
        radius, k, at_arc = float(self.far_radius), entry.k.values, entry.response.values
        nearer = at_arc.copy()
        nearer[np.isin(k, entry.k_felt.values)] = entry.response_nearer.values
        axis = Axis(SCALE_LOWEST / radius, float(self.k_max), body.rolling_radius)
        samples = Samples(axis, k, np.stack([at_arc, nearer], axis=1), entry["last"].values.astype(bool))
        return Responses(
            replace(body, domain=replace(body.domain, far_radius=radius)),
            self.loads,
            entry.s.values,
            samples,
            entry.response_coarser.values,
            cost_from(entry.attrs["cost"]),
            (entry.vertices.values, entry.triangles.values),
        )

    def serves(self, request: HarmonicRequest) -> bool:
        """Whether the model has all that a request needs, at least as accurate.

        Its far arc is as far away as requested or, if it approximates infinity, farther. Its loads make up
        each requested load; a single one does so where M is fitted, for only there are the cells as small as
        M needs them.
        """
        patches = [load.patch for load in request.requested_loads]
        apart = SAME_PLACE * min(patch.b for patch in patches)
        requested, cells = request.cells, Cells(*self.cells.tolist())
        radius, loads = request.body.domain.far_radius, self.loads
        members = {load: len(_members(loads, load)) for load in request.requested_loads}
        return bool(
            ROUNDING * self.far_radius >= radius
            and not (request.given_domain and self.far_radius > ROUNDING * radius)
            and ROUNDING * self.k_max >= request.k_max
            and self.accuracy <= AS_ACCURATE * np.min(request.accuracy)
            and np.min(self.strips[:, 0]) <= ROUNDING * min(patch.a for patch in patches)
            and cells.smallest <= ROUNDING * requested.smallest
            and cells.growth <= ROUNDING * requested.growth
            and np.all(np.min(np.abs(self.s[:, None] - request.requested_s), axis=0) < apart)
            and all(n == 1 if load.patch in request.fit_patches else n > 0 for load, n in members.items())
        )


def _members(loads: Sequence[Load], load: Load) -> Indices:
    """Return the numbers of loads on equal strips that make up the strip of a load; none if there are none.

    The length of patches along x does not matter.
    """
    s, b = (np.array([getattr(other.patch, name) for other in loads]) for name in ("s", "b"))
    apart = SAME_PLACE * load.patch.b
    inside = np.abs(s - load.patch.s) + b < load.patch.b + apart
    inside &= np.array([other.direction == load.direction for other in loads])
    for half_width in -np.unique(-b[inside]):
        numbers = np.flatnonzero(inside & (b == half_width))
        n = round(load.patch.b / half_width)
        if abs(n * half_width - load.patch.b) > apart:
            continue
        centres = load.patch.s - load.patch.b + half_width * (1 + 2 * np.arange(n))
        gaps = np.abs(s[numbers] - centres[:, None])
        if np.max(np.min(gaps, axis=1)) < apart:
            return np.asarray(numbers[np.argmin(gaps, axis=1)])
    return np.empty(0, dtype=int)
