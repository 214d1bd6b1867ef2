"""Dang Van's equivalent stress: high-cycle fatigue of a point by its history of stresses.

Grains that yield a little shake down to an elastic cycle by residual stresses of their own: the stress
deviator then cycles about the centre of the smallest sphere that encloses its path. With tau_a(t) the largest
shear stress (Tresca) of the deviator less that centre, and sigma_h(t) the hydrostatic stress, the equivalent
stress is

    tau_eq = max over t of tau_a(t) + c sigma_h(t),

and fatigue is to be expected where it exceeds the fatigue limit in shear. The sphere is one in the norm
(s : s)^1/2 of deviators. Source: Dang Van, Griveau and Message (1989), On a new multiaxial fatigue limit
criterion, in Biaxial and Multiaxial Fatigue, EGF 3, 479-496; for wheels Ekberg, Kabo and Andersson (2002), as
in `femic.damage.fatigue`.
"""

from dataclasses import dataclass

import numpy as np

from femic.damage.dang_van import DangVan
from femic.damage.hypersphere import smallest_hypersphere
from geometries.arrays import Array
from geometries.errors import WrongInput

SYMMETRY = 1e-9  # of stresses, as a share of the largest one


@dataclass(frozen=True, eq=False)
class EquivalentStress:
    """Equivalent stresses of points [MPa], (...), the steps at which they occur, and their parts there.

    `shear` is tau_a [MPa], `hydrostatic` is sigma_h [MPa], each (...).
    """

    value: Array
    step: Array
    shear: Array
    hydrostatic: Array


def equivalent_stress(stresses: Array, criterion: DangVan) -> EquivalentStress:
    """Return Dang Van's equivalent stress of points over one cycle of stresses [MPa], (n_steps, ..., 3, 3).

    Residual stresses that stay are part of the stresses; of them only the hydrostatic one matters. Raises
    WrongInput for other shapes, values that are not finite, and tensors that are not symmetric.
    """
    stresses = _checked(stresses)
    hydrostatic = np.trace(stresses, axis1=-2, axis2=-1) / 3  # (n_steps, ...)
    deviators = stresses - hydrostatic[..., None, None] * np.eye(3)
    shear = shear_amplitudes(deviators)
    weight = criterion.hydrostatic * np.where(hydrostatic < 0, criterion.compression, 1.0)
    equivalent = shear + weight * hydrostatic
    step = np.argmax(equivalent, axis=0)
    value, at_shear, at_hydrostatic = (
        np.take_along_axis(part, step[None], axis=0)[0] for part in (equivalent, shear, hydrostatic)
    )
    return EquivalentStress(value, step, at_shear, at_hydrostatic)


def shear_amplitudes(deviators: Array) -> Array:
    """Return tau_a(t) [MPa], (n_steps, ...), of deviators [MPa], (n_steps, ..., 3, 3)."""
    n_steps = len(deviators)
    paths = np.moveaxis(_coordinates(deviators).reshape(n_steps, -1, 5), 1, 0)  # (points, n_steps, 5)
    centres = np.array([smallest_hypersphere(path).centre for path in paths]).reshape(-1, 5)
    cycles = deviators - _deviator(centres).reshape(deviators.shape[1:])
    principal = np.linalg.eigvalsh(cycles)
    return np.asarray((principal[..., 2] - principal[..., 0]) / 2)


def tensors(components: Array) -> Array:
    """Return tensors (..., 3, 3) of components (..., 6) in the order xx, ss, nn, sn, xn, xs."""
    components = np.asarray(components, dtype=float)
    if components.shape[-1:] != (6,):
        raise WrongInput(f"components of shape {components.shape}: six in the last axis, xx ss nn sn xn xs")
    order = np.array([[0, 5, 4], [5, 1, 3], [4, 3, 2]])
    return np.asarray(components[..., order])


def _coordinates(deviators: Array) -> Array:
    """Return deviators (..., 3, 3) as vectors (..., 5) with the same norm and inner products."""
    s = deviators
    return np.stack(
        [
            np.sqrt(1.5) * s[..., 0, 0],
            (s[..., 1, 1] - s[..., 2, 2]) / np.sqrt(2),
            *(np.sqrt(2) * s[..., i, j] for i, j in ((0, 1), (1, 2), (0, 2))),
        ],
        axis=-1,
    )


def _deviator(vectors: Array) -> Array:
    """Return the deviators (..., 3, 3) of vectors (..., 5)."""
    first, second, *shears = np.moveaxis(vectors, -1, 0)
    xx = first / np.sqrt(1.5)
    ss, nn = (-xx + sign * np.sqrt(2) * second for sign in (1, -1))
    xs, sn, xn = (shear / np.sqrt(2) for shear in shears)
    return tensors(np.stack([xx, ss / 2, nn / 2, sn, xn, xs], axis=-1))


def _checked(stresses: Array) -> Array:
    """Return stresses as an array; raises WrongInput for wrong ones."""
    stresses = np.asarray(stresses, dtype=float)
    if stresses.ndim < 3 or stresses.shape[-2:] != (3, 3) or len(stresses) == 0:
        raise WrongInput(
            f"stresses of shape {stresses.shape}: (n_steps, ..., 3, 3); six components become tensors by "
            "femic.damage.equivalent_stress.tensors"
        )
    if not np.all(np.isfinite(stresses)):
        raise WrongInput("stresses with values that are not finite: leave out points outside of the bodies")
    asymmetry = np.max(np.abs(stresses - np.swapaxes(stresses, -1, -2)), initial=0.0)
    if asymmetry > SYMMETRY * np.max(np.abs(stresses), initial=0.0):
        raise WrongInput(f"stresses that are not symmetric, by {asymmetry:.3g} MPa: give symmetric tensors")
    return stresses
