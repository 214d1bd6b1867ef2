"""The stiffness on a curved mesh: kernel, constant strain, energy."""

import numpy as np
import pytest
from skfem import Basis, ElementTetP2

from femic.reference.solid.linear import is_curved, rigid_body_modes, stiffness
from tests.femic.reference.conftest import STEEL

STRAINS = np.array([[1.0, 0.3, -0.2], [0.1, -0.7, 0.4], [0.5, 0.2, 0.6]])


def test_some_cells_are_curved_and_most_are_not(half_model):
    share = np.mean(is_curved(half_model.solid.mesh))
    assert 0.01 < share < 0.5


def test_rigid_body_modes_are_the_kernel(half_model):
    modes = rigid_body_modes(half_model.solid.nodes)
    forces = half_model.stiffness @ modes
    # rounding: forces of a mode are sums of about 30 terms of the size |K| |mode|
    scale = np.abs(half_model.stiffness).max() * np.abs(modes).max(axis=0)
    assert np.all(np.abs(forces).max(axis=0) < 1e-12 * scale)
    assert np.linalg.matrix_rank(modes) == 6


def test_stiffness_is_symmetric(half_model):
    difference = half_model.stiffness - half_model.stiffness.T
    assert np.abs(difference).max() < 1e-13 * np.abs(half_model.stiffness).max()


def test_constant_strain_is_in_equilibrium_inside(half_model):
    mesh = half_model.solid.mesh
    forces = (half_model.stiffness @ (STRAINS @ half_model.solid.nodes).T.ravel()).reshape(-1, 3)
    inside = np.ones(len(forces), dtype=bool)
    inside[mesh.dofs.get_facet_dofs(mesh.boundary_facets()).flatten()] = False
    # 1e-12: rounding; the quadrature of curved cells integrates constant stress exactly
    assert np.abs(forces[inside]).max() < 1e-12 * np.abs(forces).max()


def test_constant_strain_energy_is_the_material_law(half_model):
    mesh = half_model.solid.mesh
    u = (STRAINS @ half_model.solid.nodes).T.ravel()
    strain = (STRAINS + STRAINS.T) / 2
    density = STEEL.lame / 2 * np.trace(strain) ** 2 + STEEL.G * np.sum(strain**2)
    unit = stiffness(mesh, STEEL)
    volume = _volume(mesh)
    assert u @ unit @ u / 2 == pytest.approx(density * volume, rel=1e-11)


def _volume(mesh):
    return Basis(mesh, ElementTetP2(), intorder=5).dx.sum()
