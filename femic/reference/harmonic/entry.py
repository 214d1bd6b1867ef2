"""Responses as an entry of the store (`femic.cache.store`), and its parts, one per wavenumber."""

import json
from dataclasses import asdict, dataclass

import numpy as np
import xarray as xr

from femic.cache.store import Store
from femic.reference.harmonic.synthesis import Responses
from femic.reference.harmonic.wavenumbers import Axis, Samples
from femic.reference.models import cost_from
from geometries.arrays import Array
from geometries.bodies import Body
from geometries.patches import DIRECTIONS, Load

WaveSolution = tuple[Array, float]  # responses (arc, load, 3, len(s)) [mm^2/N] and their residual


def to_entry(responses: Responses) -> xr.Dataset:
    """Return the entry of responses; with the nearer far arc only the responses that differ."""
    samples = responses.samples
    felt = np.any(samples.responses[:, 0] != samples.responses[:, 1], axis=(1, 2, 3))
    dims = ("load", "i", "point")
    return xr.Dataset(
        {
            "response": (("k", *dims), samples.responses[:, 0], {"units": "mm2/N"}),
            "response_nearer": (("k_felt", *dims), samples.responses[felt, 1], {"units": "mm2/N"}),
            "response_coarser": (("k_sparser", *dims), responses.coarser, {"units": "mm2/N"}),
            "last": ("k", samples.last),
            "vertices": (("yz", "vertex"), responses.drawn[0], {"units": "mm"}),
            "triangles": (("corner", "triangle"), responses.drawn[1]),
        },
        coords={
            "k": ("k", samples.k, {"units": "1/mm"}),
            "k_felt": ("k_felt", samples.k[felt], {"units": "1/mm"}),
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


def from_entry(entry: xr.Dataset, body: Body, loads: tuple[Load, ...], axis: Axis) -> Responses:
    """Return the responses of a body to loads from an entry of `to_entry`."""
    k, at_arc = entry.k.values, entry.response.values
    nearer = at_arc.copy()
    nearer[np.isin(k, entry.k_felt.values)] = entry.response_nearer.values
    samples = Samples(axis, k, np.stack([at_arc, nearer], axis=1), entry["last"].values.astype(bool))
    drawn = entry.vertices.values, entry.triangles.values
    cost = cost_from(entry.attrs["cost"])
    coarser = entry.response_coarser.values
    return Responses(body, loads, entry.s.values, samples, coarser, cost, drawn)


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
        part = {"responses": responses, "residual": np.array(residual)}
        self.store.put_part(self.key, name, part)


NOT_STORED = StoredWaves(Store(), "")
