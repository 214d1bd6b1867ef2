"""The response of a section at one wavenumber: displacements of observers under unit line loads on strips.

Where half of the section is modelled, each load is the sum of an even and an odd part; a load at s = 0 has
only one of them.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np
from scipy.sparse import csr_matrix, diags_array, kron

from femic.harmonic.section import SectionMesh
from femic.harmonic.section_model import SectionModel
from femic.harmonic.traces import Traces
from femic.symmetry import Parity, Y, parities
from geometries.arrays import Array, Indices
from geometries.patches import Load, S, X
from geometries.quadrature import on_panels

LOAD_POINTS = 4  # Gauss points per edge on a strip


class Respond:
    """Displacements of observers at arc lengths s [mm] in their local directions, at any wavenumber.

    A call returns the amplitudes of sin(k x) or cos(k x) [mm^2/N], shape (load, 3, len(s)), and the residual
    of the solved equations. The far arc lies at its radius, or at a `share` of it.
    """

    def __init__(self, model: SectionModel, loads: Sequence[Load], s: Array, shares: Sequence[float]) -> None:
        """Prepare the equations for some shares of the far radius."""
        section = model.section
        self._loads = loads
        self._parts = [_part(model, loads, s, y, shares) for y in _parities(loads, section)]
        self._axes = section.body.surface.axes(np.zeros_like(s), s)  # (direction, component, n)
        along_x = np.array([load.direction == X for load in loads])
        self._signs = np.where(along_x[:, None], [1, -1, -1], [1, 1, 1])[..., None]

    def __call__(self, k: float, share: float = 1.0) -> tuple[Array, float]:
        """The amplitudes [mm^2/N] at wavenumber k [1/mm], and the worst residual; raises NotConverged."""
        in_global_axes = np.zeros((len(self._loads), 3, self._axes.shape[2]))
        residuals = []
        for part in self._parts:
            responses, residual = part.traces[share].responses(k)
            residuals.append(residual)
            at_places = responses.reshape(-1, 3, responses.shape[1])
            observed = part.observer_signs[..., None] * at_places[part.places]
            in_global_axes[part.of_loads] += (
                part.signs[:, None, None] * np.transpose(observed, (2, 1, 0))[part.columns]
            )
        in_local_axes = np.einsum("icn,lcn->lin", self._axes, in_global_axes)
        return np.asarray(self._signs * in_local_axes), max(residuals)


@dataclass(frozen=True, eq=False)
class _Part:
    """The even or the odd part of the loads, or all of them on a whole section.

    Loads at s and -s have parts that are equal or opposite: they share a column of the forces. So do
    observers share a place.
    """

    of_loads: list[int]  # numbers of the loads that have this part
    columns: list[int]  # the column of the forces that each of these loads uses
    signs: Array  # the factor of each of these loads on its column
    places: Indices  # the place of each observer, (n,)
    observer_signs: Array  # the factors of each observer on the components at its place, (n, 3)
    traces: Mapping[float, Traces]  # by the share of the far radius at which the far arc lies


def _parities(loads: Sequence[Load], section: SectionMesh) -> list[int]:
    """Parities in y that the loads have: +1 and -1, or only 0 on a whole section."""
    return sorted({p.y for load in loads for p in parities(load, half_section=section.half_section)})


def _part(model: SectionModel, loads: Sequence[Load], s: Array, y: int, shares: Sequence[float]) -> _Part:
    """Forces, observers and equations for one parity in y and some shares of the far radius."""
    section, body = model.section, model.section.body
    load_numbers = [
        j for j, load in enumerate(loads) if any(p.y == y for p in parities(load, half_section=y != 0))
    ]
    twins = [_twin(loads[j], y) for j in load_numbers]
    distinct = list(dict.fromkeys(load for load, _ in twins))
    forces = np.stack([strip_force(section, load, y) for load in distinct], axis=1)
    nodes = section.mesh.doflocs
    on_plane = np.abs(nodes[0]) < 1e-9 * body.domain.far_radius
    held = model.supported | (on_plane[:, None] & (_mirror(y) < 0))
    radius = np.hypot(*nodes)[:, None]
    far_radius = body.domain.far_radius
    places, place_of_observer = np.unique(np.abs(s) if y else s, return_inverse=True)
    at_places, compliance = observers(section, places, y), 1 / body.material.G
    return _Part(
        load_numbers,
        [distinct.index(load) for load, _ in twins],
        np.array([sign for _, sign in twins]),
        place_of_observer,
        np.where((s < 0)[:, None], _mirror(y), 1.0),
        {
            share: Traces.of(
                model.free_of(held | (radius > share * far_radius)), forces, at_places, compliance
            )
            for share in shares
        },
    )


def _twin(load: Load, y: int) -> tuple[Load, float]:
    """The load at |s| whose part of a parity in y equals that of a load up to a factor, and this factor."""
    if y == 0 or load.patch.s >= 0:
        return load, 1.0
    mirrored = replace(load, patch=replace(load.patch, s=-load.patch.s))
    return mirrored, float(-y if load.direction == S else y)


def _mirror(y: int) -> Array:
    """Signs (3,) by which the components differ on the other side of y = 0; 1 on a whole section."""
    return Parity(1, y).signs(Y) if y else np.ones(3)


def observers(section: SectionMesh, s: Array, y: int) -> csr_matrix:
    """Matrix (3 len(s), unknowns) from amplitudes of a parity in y to u_x, u_y, u_z on the contour."""
    signs = np.where((s < 0)[:, None], _mirror(y), 1.0).ravel()
    trace = section.interpolation(np.abs(s) if y else s)
    return csr_matrix(diags_array(signs) @ kron(trace, np.eye(3), format="csr"))


def strip_force(section: SectionMesh, load: Load, y: int = 0) -> Array:
    """Consistent forces (unknowns,) of the part of a unit line load that has a parity in y.

    The line load is uniform over the strip of the load; y = 0 stands for all of it on a whole section.
    """
    low, high = load.patch.s - load.patch.b, load.patch.s + load.patch.b
    knots = np.concatenate([-section.knots, section.knots]) if y else section.knots
    edges = np.unique([low, *knots[(knots > low) & (knots < high)], high])
    nodes, weights = on_panels(edges[:-1], edges[1:], LOAD_POINTS)
    s, density = nodes.ravel(), weights.ravel() / (high - low)
    direction = section.body.surface.axes(0.0, s)[load.direction]  # (3, n)
    modelled_share = 0.5 if y else 1.0  # half of the section carries half of the even and of the odd part
    return np.asarray(modelled_share * (observers(section, s, y).T @ (density * direction).T.ravel()))
