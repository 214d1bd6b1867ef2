"""The expected wavenumbers of a request, counted on a half-space under the same loads.

The responses of the half-space are known in closed form, so the search for wavenumbers takes no mesh and a
tenth of a second. On a plane it finds the same wavenumbers; on curved bodies it finds about four fifths as
many (measured).
"""

from collections.abc import Callable, Sequence

import numpy as np

from approx.halfspace import HalfSpace
from femic.reference.harmonic.request import HarmonicRequest
from femic.reference.harmonic.wavenumbers import Samples, sample
from femic.reference.harmonic.waves import SINES, half_space_response
from geometries.arrays import Array
from geometries.materials import one_body

OBSERVERS = 60  # about as many observers are taken
DISTANCE_DIGITS = 6  # of distances in half-widths: distances that agree in these are evaluated once


def expected_samples(request: HarmonicRequest) -> Samples:
    """The half-space's samples for a request, some observers; raises NotConverged where `sample` does."""
    loads, observed = request.loads, request.observed
    chosen = slice(None, None, max(1, len(observed) // OBSERVERS))
    accuracy = np.broadcast_to(request.accuracy, (len(loads), 1, len(observed)))[..., chosen]
    directions = [load.direction for load in loads]
    return sample(
        request.axis,
        _half_space(request, observed[chosen]),
        SINES[:, directions].T[..., None],
        min(load.patch.a for load in loads),
        accuracy,
    )


def _half_space(request: HarmonicRequest, s: Array) -> Callable[[Sequence[float]], list[Array]]:
    """A function from wavenumbers [1/mm] to the half-space's responses [mm^2/N], (load, 3, len(s)) each.

    It replaces k by sqrt(k^2 + 1 / L^2) with the far radius L: as with a far arc, responses are finite at
    k = 0.
    """
    loads, body = request.loads, request.body
    half_space = HalfSpace(one_body(body.material, body.side))
    distances = np.stack([s - load.patch.s for load in loads])  # (load, observer)
    half_width = np.broadcast_to([[load.patch.b] for load in loads], distances.shape)
    pairs = np.stack([half_width, distances], axis=-1).reshape(-1, 2) / (unit := np.min(half_width))
    distinct_pairs, pair_numbers = np.unique(pairs.round(DISTANCE_DIGITS), axis=0, return_inverse=True)
    direction = np.array([[load.direction] for load in loads])

    def responses(wavenumbers: Sequence[float]) -> list[Array]:
        k = np.hypot(np.array(wavenumbers), 1 / body.domain.far_radius)
        distinct_responses = np.stack(
            [half_space_response(half_space, b, d, k) for b, d in unit * distinct_pairs]
        )
        all_responses = distinct_responses[
            pair_numbers.reshape(distances.shape)[:, None], np.arange(3)[:, None], direction[..., None]
        ]
        return list(np.moveaxis(all_responses, -1, 0))  # (k, load, i, observer)

    return responses
