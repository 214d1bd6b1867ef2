"""What elasticity demands of a section: symmetry, reciprocity, free rigid motions, balance of forces."""

from dataclasses import replace

import numpy as np
import pytest

from femic.reference.engine import Points
from femic.reference.harmonic.section import SectionSize, assemble, section_mesh
from femic.reference.harmonic.section_response import strip_force
from femic.reference.meshing import Cells
from femic.reference.run_options import Level
from geometries.bodies import Body, Domain
from geometries.patches import Load, Patch
from geometries.surfaces import LOWER, UPPER
from tests.femic.reference.conftest import STEEL, UNSYMMETRIC
from tests.femic.reference.harmonic.fields import fields, raw_ics, stiffness
from tests.femic.reference.known_bodies import harmonic_job

BARE = Cells(0.1, 0.5, 0.5)
WHEEL = Body(UPPER, UNSYMMETRIC, STEEL, Domain(40.0, 40.0), 70.0)
LOADS = tuple(Load(Patch(0.3, 0.4, s), direction) for s in (0.0, 2.0) for direction in range(3))


RAIL = replace(WHEEL, side=LOWER, rolling_radius=np.inf)


@pytest.fixture(scope="module", params=[WHEEL, RAIL], ids=["wheel", "rail"])
def model(request):
    strips = np.array([[-0.4, 0.4], [1.6, 2.4]])
    return assemble(section_mesh(request.param, SectionSize(BARE, strips)))


@pytest.mark.parametrize("k", [0.0, 0.02, 0.7, 5.0])
def test_the_stiffness_is_symmetric_and_positive_and_loads_are_reciprocal(model, k):
    forces = np.stack([strip_force(model.section, load) for load in LOADS], axis=1)
    work = forces.T @ fields(model, model.section.supported, k, forces)
    np.testing.assert_allclose(work, work.T, rtol=0, atol=1e-11 * np.max(work))
    assert np.all(np.linalg.eigvalsh((work + work.T) / 2) > 0)


def stiffness_without_supports(section, k):
    """K(k) of a section on which nothing is held."""
    return stiffness(assemble(section), k)


def share(K, u):
    """Largest force on nodes that all move by u, over the largest entry of K."""
    return np.max(np.abs(K @ np.tile(u, K.shape[0] // 3))) / np.max(np.abs(K.data))


def bare_section(body):
    return section_mesh(body, SectionSize(BARE, np.array([[-0.4, 0.4]])))


def test_a_rail_does_not_resist_translations_that_do_not_change_along_x():
    section = bare_section(RAIL)
    K = stiffness_without_supports(section, 0.0)
    for axis in range(3):
        assert share(K, np.eye(3)[axis]) < 1e-10
    assert share(stiffness_without_supports(section, 0.3), np.eye(3)[1]) > 1e-4


@pytest.mark.parametrize("side", [LOWER, UPPER])
def test_a_wheel_does_not_resist_a_translation_along_its_axis_or_across_it(side):
    """Across: of order one, u_z = cos(theta), u_x = side sin(theta) of the turned section."""
    section = bare_section(replace(WHEEL, side=side))
    assert share(stiffness_without_supports(section, 0.0), np.array([0.0, 1.0, 0.0])) < 1e-10
    of_order_one = stiffness_without_supports(section, 1 / WHEEL.rolling_radius)
    assert share(of_order_one, np.array([side, 0.0, 1.0])) < 1e-9
    assert share(of_order_one, np.array([-side, 0.0, 1.0])) > 1e-4


def test_supports_carry_the_load(model):
    """k = 0: the reactions balance a force along y."""
    force = strip_force(model.section, LOADS[1])
    u = fields(model, model.section.supported, 0.0, force[:, None])
    K = stiffness_without_supports(model.section, 0.0)
    reaction = K @ u[:, 0] - force
    carried = force[1::3].sum()
    assert carried == pytest.approx(1, rel=1e-3)  # the strip is curved: cosines of 0.05
    assert reaction[1::3].sum() == pytest.approx(-carried, rel=1e-9)
    assert np.max(np.abs(reaction[~model.section.supported.ravel()])) < 1e-9


@pytest.mark.parametrize("body", [pytest.param(WHEEL, marks=pytest.mark.slow), RAIL], ids=["wheel", "rail"])
def test_observers_in_front_and_behind_see_mirror_images(body):
    asked = harmonic_job(40.0).request(Level())
    x, s = np.array([1.5, -1.5]), np.array([0.8, 0.8])
    rough = replace(asked, cells=BARE, accuracy=100 * asked.accuracy)
    u = raw_ics(replace(rough, body=body, loads=LOADS[:3], points=Points(x, s))).u
    signs = np.outer([-1, 1, 1], [-1, 1, 1])  # load, displacement
    np.testing.assert_allclose(u[..., 1], signs * u[..., 0], rtol=0, atol=1e-12 * np.max(np.abs(u)))
