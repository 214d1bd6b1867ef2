"""Bodies that differ in Young's modulus alone share a model; displacements go like 1/E."""

from dataclasses import replace

import numpy as np
import pytest

from femic.cache.store import Store
from femic.reference.engine import Points
from femic.reference.engines import HARMONIC
from femic.reference.harmonic.stored import DIGITS, model_key, with_unit_modulus
from femic.reference.job import Job, Settings
from femic.reference.refinement import references
from femic.reference.run_options import Level, RunOptions, Watch
from geometries.bodies import Body, Domain
from geometries.contours import arc
from geometries.materials import Material
from geometries.patches import Patch

POINTS = Points(np.array([0.0, 0.5, 2.0, 6.0]), np.array([0.4, 0.4, -1.0, 3.0]))
MODULI = (210e3, 3.7)


def job(modulus):
    body = Body(-1, arc(8.0, 0.7, 0.7), Material(modulus, 0.28), Domain(160.0, np.inf))
    settings = Settings(HARMONIC, tolerance=0.1, rotation_reach=8.0, moment_arm=2.0)
    return Job(body, Patch(0.4, 0.3), ("nn", "sn"), POINTS, {"line": slice(0, 4)}, settings)


def solved(modulus, store):
    """C of a body [mm/N], and how many of its models were kept."""
    result = []
    options = RunOptions(1, store, Watch(on_model=lambda model: result.append(model.cached)))
    return references({"body": job(modulus)}, options)["body"], result


@pytest.fixture(scope="module")
def store():
    result = Store("memory://modulus")
    solved(MODULI[0], result)
    return result


def test_another_modulus_is_served_and_has_the_c_of_its_own_model(store):
    served, result = solved(MODULI[1], store)
    alone, solved_again = solved(MODULI[1], Store())
    assert all(result)
    assert not any(solved_again)
    for one, other in (
        (served.c.ic, alone.c.ic),
        (served.c.estimate, alone.c.estimate),
        (served.raw, alone.raw),
        (served.discount, alone.discount),
    ):
        np.testing.assert_allclose(one, other, rtol=1e-9, atol=1e-12 * np.nanmax(np.abs(other)))


def test_displacements_go_like_the_inverse_of_the_modulus(store):
    first, other = (solved(modulus, store)[0] for modulus in MODULI)
    ratio = MODULI[0] / MODULI[1]
    np.testing.assert_allclose(other.c.ic, ratio * first.c.ic, rtol=1e-12)
    np.testing.assert_allclose(other.c.estimate, ratio * first.c.estimate, rtol=1e-9)


def test_keys_do_not_depend_on_the_modulus_but_on_all_else():
    requests = [job(modulus).request(Level()) for modulus in (*MODULI, 71e3, 1e5 / 3, 0.1)]
    assert len({model_key(request, Store()) for request in requests}) == 1
    tighter = replace(requests[0], accuracy=requests[0].accuracy * (1 - 10.0 ** (1 - DIGITS)))
    assert model_key(tighter, Store()) != model_key(requests[0], Store())
    other = replace(requests[0], body=replace(requests[0].body, material=Material(MODULI[0], 0.3)))
    assert model_key(other, Store()) != model_key(requests[0], Store())
    assert with_unit_modulus(requests[0]).body.material.E == 1.0
