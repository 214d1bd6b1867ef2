"""Models are solved and kept for a Young's modulus of 1 MPa: displacements go like 1/E.

So bodies that differ in E alone share a model.
"""

from dataclasses import replace

import numpy as np

from femic.cache.store import Store
from femic.reference.harmonic import nesting
from femic.reference.harmonic.request import HarmonicRequest
from femic.reference.harmonic.synthesis import Responses
from geometries.arrays import Array
from geometries.bodies import Body

UNIT = 1.0  # MPa
DIGITS = 9  # significant ones of an accuracy: those of bodies with other E differ by rounding


def with_unit_modulus(request: HarmonicRequest) -> HarmonicRequest:
    """The request of the same body with E = 1 MPa."""
    body = request.body
    unit = replace(body, material=replace(body.material, E=UNIT))
    return replace(request, body=unit, accuracy=_rounded(request.accuracy * (body.material.E / UNIT)))


def with_modulus_of(body: Body, solved: Responses) -> Responses:
    """Responses for E = 1 MPa as those of a body with its own E, and with its domain."""
    factor = UNIT / body.material.E
    samples = replace(solved.samples, responses=factor * solved.samples.responses)
    own = replace(solved.body, material=body.material)
    return replace(solved, body=own, samples=samples, coarser=factor * solved.coarser)


def kept(request: HarmonicRequest, store: Store) -> Responses | None:
    """The wanted responses of a request by a kept model, whatever its E; None if there is none."""
    found = nesting.kept(with_unit_modulus(request), store)
    return None if found is None else with_modulus_of(request.body, found)


def model_key(request: HarmonicRequest, store: Store) -> str:
    """The key of the model of a request in the store, whatever E."""
    return nesting.model_key(with_unit_modulus(request), store)


def _rounded(values: Array | float) -> Array:
    """Numbers to `DIGITS`."""
    values = np.asarray(values, dtype=float)
    scale = 10.0 ** (DIGITS - 1 - np.floor(np.log10(values)))
    return np.round(values * scale) / scale
