"""T-gamma: the work of friction per rolled distance as forces times creepages, with and without spin.

The rigid slip w of a contact is split into a mean motion, a rotation about the normal, and a rest,

    w = w_0 + omega (-(s - s_0), x - x_0) + rest,

by least squares weighted with pressures; (x_0, s_0) is the centre of pressure. On a plane the rest vanishes,
-w_0x and w_0s are the longitudinal and lateral creepages of that point, and omega the spin. In conforming
contacts heights, and the rolling of inclined places, turn the slip further. With T_x, T_s and M_n, the forces
and the moment about the normal through the centre of pressure, friction takes per rolled distance

    -T_x w_0x - T_s w_0s - M_n omega - sum p_t . rest + pressures,

where the last is the work that pressures do on the distance of the surfaces (`femic.contact.rolling`).
Engineers mostly count the first two (Pearce and Sherratt 1991, Wear 144, 343-351), or three.
"""

from dataclasses import dataclass

import numpy as np

from femic.contact.rolling import RollingContact, RollingProblem
from geometries.arrays import Array
from geometries.errors import WrongInput
from geometries.patches import N


@dataclass(frozen=True)
class TGamma:
    """Shares of the work of friction per rolled distance [N], signed; `creepages` and `spin_rate` of the fit.

    `creepages` are -w_0x and w_0s, `spin_rate` omega [1/mm]. A share is negative where a force drives the
    motion of its own creepage, such as the lateral force that spin causes.
    """

    longitudinal: float
    lateral: float
    spin: float
    conformity: float
    pressures: float
    creepages: tuple[float, float]
    spin_rate: float

    @property
    def without_spin(self) -> float:
        """T-gamma of longitudinal and lateral creepage [N]."""
        return self.longitudinal + self.lateral

    @property
    def with_spin(self) -> float:
        """T-gamma with that of spin [N]."""
        return self.without_spin + self.spin

    @property
    def total(self) -> float:
        """All work of friction [N]; it tends to the sum over elements with smaller elements."""
        return self.with_spin + self.conformity + self.pressures


def t_gamma(problem: RollingProblem, rolling: RollingContact) -> TGamma:
    """Return the shares of T-gamma of a contact in steady rolling; raises WrongInput without contact."""
    p, grid = rolling.contact.p, problem.problem.grid
    pressed = p[..., N]
    if not np.any(pressed > 0):
        raise WrongInput("contact without pressure: there is no T-gamma; press the bodies together")
    w = problem.rolling.rigid_slip(rolling.creepages)
    x, s = np.broadcast_arrays(problem.rolling.x[:, None], problem.rolling.s)
    mean_x, mean_s, w_x, w_s = (
        float(np.average(values, weights=pressed)) for values in (x, s, w[..., 0], w[..., 1])
    )
    turning = np.stack([mean_s - s, x - mean_x], axis=-1)
    omega = _slope(w - [w_x, w_s], turning, pressed)
    parts = {
        "longitudinal": np.multiply(np.ones_like(w), [w_x, 0.0]),
        "lateral": np.multiply(np.ones_like(w), [0.0, w_s]),
        "spin": omega * turning,
        "conformity": w - [w_x, w_s] - omega * turning,
    }
    works = {name: -float(np.sum(p[..., :N] * part)) * grid.area for name, part in parts.items()}
    by_pressures = problem.power(rolling) - problem.climbing(rolling) - sum(works.values())
    return TGamma(**works, pressures=by_pressures, creepages=(-w_x, w_s), spin_rate=omega)


def _slope(values: Array, direction: Array, weights: Array) -> float:
    """Return the factor by which a field (n_x, n_s, 2) is nearest to weighted values of this shape."""
    square = float(np.sum(weights * np.sum(direction**2, axis=-1)))
    product = float(np.sum(weights * np.sum(values * direction, axis=-1)))
    return product / square if square > 0 else 0.0
