"""One solved model serves other grids, moduli and components; components that are asked for alone."""

from dataclasses import replace

import numpy as np
import pytest

from femic.cache.store import Store
from femic.reference.engine import Points
from femic.reference.engines import HARMONIC
from femic.reference.harmonic import stored as nesting
from femic.reference.harmonic.section_response import Condensation
from femic.reference.harmonic.stored import DIGITS, model_key, stored_model, with_unit_modulus
from femic.reference.job import Job, Settings
from femic.reference.matrix.reference import assess_matrices, column_scale, matrices
from femic.reference.refinement import references
from femic.reference.run_options import Level, RunOptions
from geometries.bodies import Body, Domain
from geometries.contours import arc
from geometries.materials import Material
from geometries.patches import COMPONENTS, Grid, Load, N, Patch, S, indices
from geometries.surfaces import LOWER, UPPER
from tests.coarse import coarse_sections
from tests.femic.reference.harmonic.test_condensation import largest
from tests.femic.reference.matrix.test_column_scales import column
from tests.femic.reference.matrix.test_matrix import ARM, matrix_job

GRID = Grid(10, 8, 0.4, 0.4)
CONTOUR = arc(10.2, 0.12, 0.12)
SERVED = {
    "twice as wide and long": Grid(5, 4, 0.8, 0.8),
    "fewer, shifted by one": Grid(10, 4, 0.4, 0.4, s=0.4),
    "more lags, longer": Grid(30, 6, 0.5, 0.4),
    "twice as wide, fewer": Grid(10, 2, 0.4, 0.8),
}


@pytest.fixture(scope="module", autouse=True)
def _coarse():
    """What serves what, and within which estimates, does not depend on how accurate C is."""
    with coarse_sections():
        yield


def job_on(grid, tolerance=0.3):
    job = matrix_job(UPPER, CONTOUR, grid, radius=300.0, tolerance=tolerance)
    return replace(job, body=replace(job.body, domain=Domain(100.0, np.inf)))


def solved(job, store):
    return matrices({"body": job}, RunOptions(2, store))["body"]


@pytest.fixture(scope="module")
def store():
    result = Store("memory://nesting")
    solved(job_on(GRID), result)
    return result


@pytest.fixture
def factored(monkeypatch):
    """Wavenumbers that are solved from here on."""
    result, respond = [], Condensation.respond
    monkeypatch.setattr(Condensation, "respond", lambda self, k, *s: result.extend(k) or respond(self, k, *s))
    return result


def test_some_of_the_strips_are_served_as_they_are(store, factored):
    """The same displacements before the discount."""
    whole, served = (solved(job_on(grid), store) for grid in (GRID, SERVED["fewer, shifted by one"]))
    assert not factored
    first = int(np.flatnonzero(np.isclose(GRID.strips, served.job.grid.strips[0]))[0])
    for strip in range(served.job.grid.n_s):
        expected = whole.raw_column(first + strip)[..., first : first + served.job.grid.n_s]
        atol = 1e-6 * np.max(np.abs(expected))
        np.testing.assert_allclose(served.raw_column(strip), expected, rtol=0, atol=atol)


@pytest.mark.slow
@pytest.mark.parametrize("grid", SERVED.values(), ids=SERVED)
def test_another_grid_is_served_within_both_estimates(store, factored, grid):
    job = job_on(grid)
    served = solved(job, store)
    assert not factored
    alone = solved(job, Store())
    assert factored
    for strip in range(grid.n_s):
        ours, own = served.column(strip), alone.column(strip)
        scale = column_scale(strip, own.ic, [job])
        off, known = (
            np.max(values / scale, axis=(2, 3))
            for values in (np.abs(ours.ic - own.ic), ours.estimate + own.estimate)
        )
        assert np.all(off <= known), (off / known, strip)


NOT_SERVED = {
    "other strips": {"grid": Grid(10, 6, 0.4, 0.5)},
    "shifted by half a strip": {"grid": Grid(10, 4, 0.4, 0.4, s=0.2)},
    "larger": {"grid": Grid(10, 10, 0.4, 0.4)},
    "four times as wide": {"grid": Grid(4, 2, 1.6, 1.6)},
    "shorter elements": {"grid": Grid(10, 4, 0.3, 0.8)},
    "tighter tolerance": {"tolerance": 1e-4},
    "other nu": {"material": Material(200e3, 0.3)},
    "larger domain": {"domain": Domain(200.0, np.inf)},
}


@pytest.mark.parametrize("change", NOT_SERVED.values(), ids=NOT_SERVED)
def test_what_the_model_does_not_have_is_not_served(store, change):
    def asked(grid=SERVED["twice as wide and long"], tolerance=0.3, **body):
        job = job_on(grid, tolerance)
        return replace(job, body=replace(job.body, **body)).request(Level())

    assert stored_model(asked(), store) is not None
    assert stored_model(asked(**change), store) is None
    assert stored_model(asked(), Store()) is None


def members(s, b, direction, further=()):
    loads = [Load(Patch(0.1, 0.2, at), i) for at in (-0.6, -0.2, 0.2, 0.6) for i in (0, 2)]
    return nesting._members([*loads, *further], Load(Patch(9.0, b, s), direction)).tolist()


def test_equal_strips_side_by_side_make_up_a_load():
    assert members(0.2, 0.2, 2) == [5]
    assert members(0.0, 0.4, 2) == [3, 5]
    assert members(0.0, 0.8, 0) == [0, 2, 4, 6]
    assert members(0.0, 0.4, 1) == []  # another direction
    assert members(0.1, 0.5, 2) == members(-0.1, 0.5, 2) == []  # more than the two that begin where it does
    assert members(0.1, 0.2, 2) == members(0.0, 0.5, 2) == members(0.0, 0.6, 2) == members(0.0, 1.2, 0) == []
    assert members(0.4, 0.4, 0, [Load(Patch(0.1, 0.4, 0.4), 0)]) == [8]  # rather than two


# --- other moduli --------------------------------------------------------------------------------------

MODULI = (210e3, 3.7)


def job(modulus):
    """One load on a body of some modulus."""
    body = Body(LOWER, arc(8.0, 0.7, 0.7), Material(modulus, 0.28), Domain(160.0, np.inf))
    settings = Settings(HARMONIC, tolerance=0.1, rotation_reach=8.0, moment_arm=2.0)
    points = Points(np.array([0.0, 0.5, 2.0, 6.0]), np.array([0.4, 0.4, -1.0, 3.0]))
    return Job(body, Patch(0.4, 0.3), ("nn", "sn"), points, {"line": slice(0, 4)}, settings)


def test_another_modulus_is_served_and_has_the_c_of_its_own_model(factored):
    """Displacements go like the inverse of the modulus."""
    store = Store("memory://modulus")
    first = references({"body": job(MODULI[0])}, RunOptions(1, store))["body"]
    factored.clear()
    served = references({"body": job(MODULI[1])}, RunOptions(1, store))["body"]
    assert not factored
    alone = references({"body": job(MODULI[1])}, RunOptions(1, Store()))["body"]
    assert factored
    for ours, own in (
        (served.c.ic, alone.c.ic),
        (served.c.estimate, alone.c.estimate),
        (served.raw, alone.raw),
        (served.discount, alone.discount),
    ):
        np.testing.assert_allclose(ours, own, rtol=1e-9, atol=1e-12 * np.nanmax(np.abs(own)))
    ratio = MODULI[0] / MODULI[1]
    np.testing.assert_allclose(served.c.ic, ratio * first.c.ic, rtol=1e-12)
    np.testing.assert_allclose(served.c.estimate, ratio * first.c.estimate, rtol=1e-9)


def test_keys_do_not_depend_on_the_modulus_but_on_all_else():
    requests = [job(modulus).request(Level()) for modulus in (*MODULI, 71e3, 1e5 / 3, 0.1)]
    (key,) = {model_key(request, Store()) for request in requests}
    tighter = replace(requests[0], accuracy=requests[0].accuracy * (1 - 10.0 ** (1 - DIGITS)))
    other = replace(requests[0], body=replace(requests[0].body, material=Material(MODULI[0], 0.3)))
    assert model_key(tighter, Store()) != key != model_key(other, Store())
    assert with_unit_modulus(requests[0]).body.material.E == 1.0


# --- some components -----------------------------------------------------------------------------------

NN = ("nn",)
SMALL = Grid(6, 4, 0.4, 0.4)
BODIES = {
    "wheel": (UPPER, arc(10.2, 0.12, 0.12), 300.0),
    "rail without symmetry": (LOWER, arc(10.0, 0.12, 0.3), np.inf),
}


def of_all(body):
    side, contour, radius = BODIES[body]
    job = matrix_job(side, contour, SMALL, radius, 0.3)
    return replace(job, body=replace(job.body, domain=Domain(100.0, np.inf)))


@pytest.fixture(scope="module")
def of_nn():
    """Models that were solved for nn alone."""
    return Store("memory://nn alone")


@pytest.fixture(
    scope="module", params=["wheel", pytest.param("rail without symmetry", marks=pytest.mark.slow)]
)
def both(request, of_nn):
    """The matrix of all components, that of nn alone, and that of nn by the model of all."""
    job = of_all(request.param)
    store = Store(f"memory://components of a {request.param}")
    whole = solved(job, store)
    alone = replace(job, components=NN)
    return whole, solved(alone, of_nn), solved(alone, store)


def test_c_of_one_component_agrees_with_c_of_all_within_both_estimates(both):
    whole, alone, _ = both
    for strip in range(SMALL.n_s):
        ours, of_whole = alone.column(strip), whole.column(strip)
        scale = column_scale(strip, of_whole.ic, [whole.job])[N, N]
        off, known = (
            np.max(values[N, N] / scale)
            for values in (np.abs(ours.ic - of_whole.ic), ours.estimate + of_whole.estimate)
        )
        assert off <= known, strip


def test_it_is_the_same_to_rounding_by_the_same_model(both):
    whole, _, served = both
    for strip in range(SMALL.n_s):
        for part in ("ic", "estimate"):
            ours, of_whole = (getattr(result.column(strip), part)[N, N] for result in (served, whole))
            np.testing.assert_allclose(ours, of_whole, rtol=1e-6, atol=1e-9 * largest(of_whole))
        raw = whole.raw_column(strip)[N, N]
        np.testing.assert_allclose(served.raw_column(strip)[N, N], raw, rtol=0, atol=1e-12 * largest(raw))


def test_components_that_are_not_requested_are_nan(both):
    _, alone, _ = both
    for part in ("ic", "estimate"):
        values = getattr(alone.column(2), part).reshape(9, -1)
        known = np.all(np.isfinite(values), axis=1)
        assert [name for name, result in zip(COMPONENTS, known, strict=True) if result] == ["nn"]
        assert np.all(np.isnan(values[~known]))


def test_only_loads_are_solved_that_nn_and_m_need():
    """Besides the strips under n: a lateral load, and normal ones at the contact centre and at the arm."""
    loads = replace(of_all("wheel"), components=NN).request(Level()).requested_loads
    strips = {SMALL.patch(strip) for strip in range(SMALL.n_s)}
    assert {load.direction for load in loads if load.patch in strips} == {N}
    further = {(load.patch.s, load.direction) for load in loads if load.patch not in strips}
    assert further == {(0.0, S), (0.0, N), (ARM, N)}


# --- refinement ----------------------------------------------------------------------------------------


class Known:
    """A matrix whose errors are made up: that of nn is small, that of xs large."""

    level, cells = Level(), 1.0

    def __init__(self):
        error = {indices("nn"): 1e-3, indices("xs"): 1e3}
        entries = {(*place, lag, strip): e for place, e in error.items() for lag, strip in np.ndindex(7, 6)}
        self.made = column(mesh_error=entries)

    def column(self, _):
        return self.made


@pytest.mark.parametrize("combined", [False, True])
def test_only_requested_components_are_assessed(combined):
    """Near the load, where the scale of all is 5 A_nn, errors of 1e-3 in nn and 1e3 in xs."""
    grid, result = Grid(7, 6, 0.4, 0.5), Known()
    worst = {}
    for components in (NN, COMPONENTS):
        jobs = {name: replace(of_all("wheel"), grid=grid, components=components) for name in ("a", "b")}
        assessed = assess_matrices(jobs, dict.fromkeys(jobs, result), combined=combined)
        worst[components] = [assessed.own["a"]]
        worst[components] += [assessed.combined, assessed.in_combined["b"]] if combined else []
    for alone, of_nine in zip(worst[NN], worst[COMPONENTS], strict=True):
        assert (alone.component, of_nine.component) == ("nn", "xs")
        assert of_nine.total / alone.total == pytest.approx(1e6)


# --- store and plan ------------------------------------------------------------------------------------


def test_a_model_of_nn_does_not_serve_other_components(both, of_nn):
    _, alone, _ = both
    assert stored_model(alone.job.request(Level()), Store("memory://nothing")) is None
    assert stored_model(alone.job.request(Level()), of_nn) is not None
    for components in (COMPONENTS, ("ss",), ("xn",)):
        other = replace(alone.job, components=components)
        assert stored_model(other.request(Level()), of_nn) is None


def test_a_plan_counts_the_fields_that_are_solved():
    """On half a section two strips, and the loads of M on two widths of strips: nn needs none along x."""
    fewer, all_nine = (
        HARMONIC.expected_cost(replace(of_all("wheel"), components=components).request(Level()), 1)
        for components in (NN, COMPONENTS)
    )
    assert (fewer.fields, all_nine.fields) == (2 + 2 * 3, 3 * 2 + 2 * 4)
    assert fewer.wavenumbers <= all_nine.wavenumbers
    assert fewer.seconds <= all_nine.seconds
    assert fewer.unknowns == all_nine.unknowns
