"""Models are solved and stored for a Young's modulus of 1 MPa, because displacements are proportional to 1/E.

Bodies that differ only in E share a model.
"""

from dataclasses import replace

import numpy as np

from femic.reference.harmonic.request import HarmonicRequest
from femic.reference.harmonic.synthesis import Responses
from geometries.arrays import Array
from geometries.bodies import Body

UNIT = 1.0  # MPa
DIGITS = 9  # significant digits of an accuracy: it differs by rounding between bodies with different E


def with_unit_modulus(request: HarmonicRequest) -> HarmonicRequest:
    """Return the request for the same body with E = 1 MPa."""
    body = request.body
    unit = replace(body, material=replace(body.material, E=UNIT))
    return replace(request, body=unit, accuracy=_rounded(request.accuracy * (body.material.E / UNIT)))


def with_modulus_of(body: Body, solved: Responses) -> Responses:
    """Return the responses of a body with its own E from responses for E = 1 MPa."""
    factor = UNIT / body.material.E
    samples = replace(solved.samples, responses=factor * solved.samples.responses)
    own = replace(solved.body, material=body.material)
    return replace(solved, body=own, samples=samples, coarser=factor * solved.coarser)


def _rounded(values: Array | float) -> Array:
    """Return values rounded to `DIGITS`."""
    values = np.asarray(values, dtype=float)
    scale = 10.0 ** (DIGITS - 1 - np.floor(np.log10(values)))
    return np.round(values * scale) / scale
