"""Differences of displacements by A and by B-hat under given pressures, mapped from patch to patch."""

from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from itertools import product

import numpy as np
from scipy.interpolate import RegularGridInterpolator

from femic.contact.pairs.frictionless import SolvedContact
from femic.contact.pairs.quantities import half_length, s_range
from geometries.arrays import Array, Mask

REFERENCE = "Bhat"  # the ICs that A is compared with


@dataclass(frozen=True, eq=False)
class Sensitivity:
    """(u_n by A - u_n by B-hat) / max u_n by B-hat on a patch, due to the pressures of another contact."""

    pressures: str  # the name of the contact that the pressures are from
    patch: str  # the name of the contact that the patch is from
    x: Array  # [mm], (n_x,)
    s: Array  # [mm], (n_s,)
    on_patch: Mask  # (n_x, n_s)
    difference: Array  # (n_x, n_s)

    @property
    def inside(self) -> Array:
        """The differences on the patch, (n,)."""
        return np.asarray(self.difference[self.on_patch])

    @property
    def largest(self) -> float:
        """The largest difference on the patch."""
        return float(np.max(np.abs(self.inside)))


def sensitivities(contacts: Mapping[str, SolvedContact]) -> Iterator[Sensitivity]:
    """Yield the sensitivities to the pressures of every contact on the patch of every contact."""
    for (source, pressures), (name, patch) in product(contacts.items(), repeat=2):
        p = mapped(pressures, patch)
        by_a, by_bhat = (patch.on_grid.operator(ics)(p[..., None])[..., 0] for ics in ("A", REFERENCE))
        difference = (by_a - by_bhat) / np.max(by_bhat)
        yield Sensitivity(
            source, name, patch.on_grid.x, patch.on_grid.grid.strips, patch.normal.p > 0, difference
        )


def mapped(contact: SolvedContact, patch: SolvedContact) -> Array:
    """Return the pressures of one contact on the patch of another, at equal x / a and s / b; (n_x, n_s)."""
    interpolate = RegularGridInterpolator(
        _normalised(contact), contact.normal.p, bounds_error=False, fill_value=0.0
    )
    return np.asarray(interpolate(np.stack(np.meshgrid(*_normalised(patch), indexing="ij"), axis=-1)))


def _normalised(contact: SolvedContact) -> tuple[Array, Array]:
    """Return x over the half-length, and s from the middle over the half-width of the patch."""
    on_grid = contact.on_grid
    low, high = s_range(on_grid, contact.normal)
    s = (on_grid.grid.strips - (low + high) / 2) / ((high - low) / 2)
    return on_grid.x / half_length(on_grid, contact.normal), s
