"""What is refined, how far, and what is refused; engines that give C and its error."""

import pickle
from dataclasses import dataclass, field, replace

import numpy as np
import pytest

from approx.halfspace import HalfSpace
from femic.reference.engine import Cost, Points
from femic.reference.engines import ENGINES, HARMONIC, SOLID
from femic.reference.job import Job, NotConverged, Settings, Shares
from femic.reference.refinement import (
    Assessment,
    _steps,
    assess_references,
    next_level,
    next_levels,
    references,
)
from femic.reference.result import EstimatedICs, combine, scales, shares, total, worst
from femic.reference.run_options import MODELS, Level, RunOptions, Watch, factors
from femic.reference.solid import engine as solid
from geometries.bodies import Body, Domain
from geometries.contours import plane
from geometries.errors import WrongInput
from geometries.materials import Material, one_body
from geometries.surfaces import LOWER, UPPER
from tests.femic.reference.closed_engine import CLOSED, OFF
from tests.femic.reference.conftest import COARSE, JOB, LINES, PATCH, STEEL, changed


def with_errors(models, mesh, truncation, waves=0.0):
    """A reference whose two estimates are the given shares of max C_nn on each line."""
    reference = combine(JOB, Level(), models)
    scale = np.zeros(len(JOB.points.x))
    for part in LINES.values():
        scale[part] = np.abs(reference.c.ic[2, 2, part]).max()
    whole = np.broadcast_to(scale, reference.c.ic.shape)
    return replace(reference, c=EstimatedICs(reference.c.ic, mesh * whole, truncation * whole, waves * whole))


def own_shares(job, reference):
    return shares(job, reference.c, scales([job], reference.c.ic))


def met(job, reference):
    return own_shares(job, reference).total <= job.settings.tolerance


@pytest.mark.parametrize("engine", [CLOSED, pytest.param(SOLID, marks=pytest.mark.slow)])
def test_refinement_goes_on_until_the_tolerance_is_met_and_solves_no_model_twice(engine):
    asked = []
    watch = Watch(asked.append)
    job = changed(JOB, tolerance=0.002, engine=engine, most_unknowns=400_000)
    result = references({"lower": job}, RunOptions(1, watch=watch))["lower"]
    assert len(asked) > 1
    flat = [task.level for tasks in asked for task in tasks]
    assert len(set(flat)) == len(flat)
    assert result.level != Level()
    assert met(job, result)
    cells, domain = factors(result.level)
    assert result.cells == COARSE.scaled(cells)
    assert result.body.domain == JOB.body.domain.scaled(domain)
    assert len(result.models) == len(flat)


def given(job, **keys):
    """A job whose boundaries are given, or some of them."""
    domain = replace(job.body.domain, **{"radius_given": True, "length_given": True} | keys)
    return replace(job, body=replace(job.body, domain=domain))


def test_given_boundaries_have_no_part_in_the_estimate_and_no_model_of_their_own(models):
    truncated, own = combine(JOB, Level(), models), combine(given(JOB), Level(), models)
    assert np.nanmax(truncated.c.truncation_error) > 0
    assert np.nanmax(own.c.truncation_error) == 0
    np.testing.assert_array_equal(own.c.mesh_error, truncated.c.mesh_error)
    assert (set(truncated.models), set(own.models) - {"earlier 1"}) == (set(MODELS), {"fine", "coarse"})


def test_of_two_boundaries_the_one_that_is_not_given_counts_and_moves(models):
    half = given(JOB, length_given=False)
    assert np.nanmax(combine(half, Level(), models).c.truncation_error) > 0
    domain = half.request(Level(domain=1)).body.domain
    assert (domain.far_radius, domain.half_length) == (40.0, 100.0)
    assert given(JOB).request(Level(domain=1)).body.domain == given(JOB).body.domain


def test_sum_of_both_bodies_is_assessed_too(models):
    """Opposite ICs of two bodies cancel: their errors do not, and the scale of the sum is small."""
    job = changed(JOB, tolerance=0.02, most_unknowns=10_000_000)
    good, poor = with_errors(models, 0.001, 0.0), with_errors(models, 0.011, 0.0)
    opposite = replace(poor, c=replace(poor.c, ic=-0.95 * good.c.ic))
    jobs = {"lower": job, "upper": job}

    def refined(upper, combined):
        result = {"lower": good, "upper": upper}
        return set(next_levels(jobs, result, assess_references(jobs, result, combined=combined)))

    assert refined(opposite, combined=False) == set()
    assert refined(opposite, combined=True) == {"upper"}
    assert refined(poor, combined=True) == set()


def test_a_first_model_beyond_the_limit_is_refused():
    with pytest.raises(NotConverged, match=r"a model needs [\d,]+ unknowns, `most_unknowns` = 1,000"):
        references({"lower": changed(JOB, most_unknowns=1000)}, RunOptions(1))


def test_points_outside_the_smallest_model_are_refused_before_any_work(monkeypatch):
    monkeypatch.setattr(solid, "build_mesh", lambda _: pytest.fail("a mesh was made"))
    far = replace(JOB, points=Points(np.array([30.0]), np.array([0.0])), lines={"far": slice(0, 1)})
    with pytest.raises(WrongInput, match=r"lower body: the point s = 0 mm, 30 mm along x, .* 25 mm along x"):
        references({"lower": far}, RunOptions(1))  # the small model goes to x = 25 mm
    with pytest.raises(WrongInput, match="lies outside"):
        references({"lower": replace(JOB, patch=replace(PATCH, s=22.0))}, RunOptions(1))


def without_nn(models, job, share):
    """A reference of which xx alone was solved: it is 0, its estimate the given share of its scale."""
    ic, error = np.full((2, 3, 3, len(JOB.points.x)), np.nan)
    ic[0, 0] = 0.0
    for line, scale in scales([job], ic).items():
        error[0, 0, LINES[line]] = share * scale[0, 0]
    return replace(combine(JOB, Level(), models), c=EstimatedICs(ic, error, 0 * error, 0 * error))


def test_without_nn_the_sum_of_both_half_spaces_is_the_scale_of_the_sum(models):
    """What is a share of each body's scale is the same share of the scale of their sum."""
    job = changed(replace(JOB, components=("xx",)), tolerance=0.02)
    softer = replace(JOB.body, side=UPPER, material=Material(70e3, 0.33))
    jobs = {"lower": job, "upper": replace(job, body=softer)}
    result = {
        name: without_nn(models, of_body, 0.7 * job.settings.tolerance) for name, of_body in jobs.items()
    }
    c = total([reference.c for reference in result.values()])
    share, *_ = worst(job, c.estimate, scales(list(jobs.values()), c.ic))
    assert share == pytest.approx(0.7 * job.settings.tolerance)
    assert next_levels(jobs, result, assess_references(jobs, result, combined=True)) == {}


# --- how far: arithmetic on estimates made by hand -------------------------------------------------------

LARGE = Settings(HARMONIC, most_unknowns=10**9)


@dataclass(frozen=True)
class FakeJob:
    """What a job may take."""

    settings: Settings = LARGE


@dataclass(frozen=True)
class FakeResult:
    """How far a body has been refined, and how large it is."""

    level: Level = field(default_factory=Level)
    models: dict = field(default_factory=lambda: {"fine": Cost(1000, 1, "", (), 0.0, {}, 0.0)})


GOOD = Shares(0.0, 0.0, 0.0, 0.001, "nn", "x")


def parts(mesh=0.0, truncation=0.0, waves=0.0):
    return Shares(mesh, truncation, waves, mesh + truncation + waves, "sn", "y")


@pytest.mark.parametrize("gain", [1.5**3, 4.0, 8.0])
def test_as_many_steps_as_bring_a_part_to_half_of_the_tolerance_but_three_at_most(gain):
    for steps in (0, 1, 2, 3):
        assert _steps(0.005 * gain**steps * 0.999, 0.01, gain) == steps
        assert _steps(0.005 * gain**steps * 1.001, 0.01, gain) == min(steps + 1, 3)
    assert _steps(0.005, 0.01, gain) == 0
    assert _steps(np.inf, 0.01, gain) == 3


@pytest.mark.parametrize("start", [Level(), Level(1, -1, 1)])
@pytest.mark.parametrize(
    ("part", "gain", "name"), [("mesh", 1.5**3, "cells"), ("truncation", 4, "domain"), ("waves", 8, "waves")]
)
def test_each_part_refines_what_causes_it_by_its_own_gain_from_where_it_is(part, gain, name, start):
    for steps in (1, 2):
        error = 0.005 * gain**steps
        for factor, more in ((0.99, steps), (1.01, steps + 1)):
            level = next_level("lower", FakeJob(), FakeResult(start), parts(**{part: factor * error}))
            assert level == replace(start, **{name: getattr(start, name) + more})


def test_of_the_sum_a_body_may_take_its_share_and_parts_of_the_sum_are_refined_by_cells():
    """Of three parts of 0.4 of the tolerance each cells are refined, or refinement would go on for ever."""

    def refined(share=1.0, **errors):
        return next_level("lower", FakeJob(), FakeResult(), parts(**errors), share)

    assert refined(0.5, truncation=0.019) == Level(0, 2)
    assert refined(truncation=0.019) == Level(0, 1)
    assert refined(0.5, truncation=0.004, mesh=0.004) == Level(1, 1)
    assert refined(mesh=0.004, truncation=0.004, waves=0.004) == Level(1)


@pytest.mark.parametrize(("engine", "growth"), [("solid", 2.7), ("harmonic", 2.0)])
def test_a_model_that_would_be_too_large_is_refused_with_its_size(engine, growth):
    """Two steps of cells: 1.5^(2 growth) times the unknowns."""
    expected = round(1000 * 1.5 ** (2 * growth))
    estimated = parts(mesh=0.03)
    allowed = Settings(ENGINES[engine], most_unknowns=expected)
    assert next_level("lower", FakeJob(allowed), FakeResult(), estimated) == Level(2)
    with pytest.raises(NotConverged, match=f"about {expected:,} unknowns"):
        next_level("lower", FakeJob(replace(allowed, most_unknowns=expected - 1)), FakeResult(), estimated)


@pytest.mark.parametrize(("part", "name"), [("mesh", "cells"), ("truncation", "domain"), ("waves", "waves")])
def test_four_steps_from_the_start_are_the_furthest(part, name):
    estimated = parts(**{part: 0.006})
    near, far = (FakeResult(replace(Level(), **{name: done})) for done in (3, 4))
    assert getattr(next_level("lower", FakeJob(), near, estimated), name) == 4
    with pytest.raises(NotConverged):
        next_level("lower", FakeJob(), far, estimated)


def test_the_refusal_says_what_was_reached():
    result = FakeResult(Level(1, 2))
    estimated = Shares(0.3, 0.2, 0.1, 0.6, "sn", "y")
    says = (
        r"lower body: the estimated error of C_sn on the line y is 60\.00% with 1,000 unknowns, "
        r"cells x 0\.667, domain x 4 \(at worst 30\.00% from the mesh, 20\.00% from the domain, 10\.00% from "
        r"the wavenumbers\); the tolerance 1\.00% .* more than 16 times the first"
    )
    with pytest.raises(NotConverged, match=says):
        next_level("lower", FakeJob(Settings(HARMONIC, most_unknowns=10)), result, estimated)


BODIES = {"lower": FakeJob(), "upper": FakeJob()}
RESULTS = {"lower": FakeResult(), "upper": FakeResult()}


def test_body_within_its_tolerance_is_not_refined():
    just, bad, finer = replace(GOOD, total=0.01), parts(truncation=0.0101), {"upper": Level(0, 1)}
    for upper, refined in ((GOOD, {}), (bad, finer), (replace(bad, total=np.nan), finer)):
        assert next_levels(BODIES, RESULTS, Assessment({"lower": just, "upper": upper})) == refined


def test_sum_is_assessed_after_each_body_and_refines_the_worse_one():
    """By half of the tolerance of the sum."""
    bad, worse = parts(truncation=0.006), parts(truncation=0.007)
    own = {"lower": GOOD, "upper": GOOD}
    together = Assessment(own, parts(truncation=0.013), {"lower": worse, "upper": bad})
    assert next_levels(BODIES, RESULTS, together) == {"lower": Level(0, 1)}
    assert next_levels(BODIES, RESULTS, replace(together, combined=replace(GOOD, total=0.01))) == {}
    short = replace(together, own={"lower": GOOD, "upper": parts(mesh=0.02)})
    assert next_levels(BODIES, RESULTS, short) == {"upper": Level(2)}
    # a quarter of it is below a quarter of 0.02, a sixteenth below 0.0025
    mine = replace(together, in_combined={"lower": parts(truncation=0.0199), "upper": GOOD})
    assert next_levels(BODIES, RESULTS, mine) == {"lower": Level(0, 2)}


# --- engines ---------------------------------------------------------------------------------------------

ON_PLANE = Body(LOWER, plane(), STEEL, Domain(100.0, np.inf))
OBSERVERS = Points(np.array([2.0, 4.0, 8.0]), np.array([0.5, 0.0, -3.0]))


@pytest.mark.parametrize("name", ENGINES)
def test_an_engine_is_known_by_its_name_and_solves_what_gives_c_and_its_error(name):
    engine = ENGINES[name]
    assert engine.name == name
    assert pickle.loads(pickle.dumps(engine)) is engine
    assert engine.models == MODELS[: len(engine.models)] == MODELS[: {"harmonic": 1, "solid": 3}[name]]
    assert list(Level(1, 1).models(MODELS).values()) == [Level(1, 1), Level(0, 1), Level(0, 0)]
    assert engine.safety >= 1
    job = Job(ON_PLANE, PATCH, ("sn",), OBSERVERS, {"all": slice(None)}, Settings(engine))
    request = job.request(Level())
    assert request.loads[: len(job.loads)] == job.loads
    np.testing.assert_array_equal(request.points.x[:3], OBSERVERS.x)
    assert request.cells == job.first_cells


# --- an engine of closed formulas --------------------------------------------------------------------------


def c_of(tolerance, **settings):
    settings = Settings(CLOSED, tolerance, rotation_reach=12.0, **settings)
    job = Job(ON_PLANE, PATCH, ("nn", "xn"), OBSERVERS, {"all": slice(None)}, settings)
    return references({"lower": job}, RunOptions(1))["lower"]


@pytest.mark.parametrize("tolerance", [0.1, 0.01, 1e-3])
def test_a_new_engine_is_driven_by_its_class_alone(tolerance):
    """On a plane the discount of A is that of a point, so that C is A but for the share that is wrong."""
    result = c_of(tolerance)
    a = HalfSpace(one_body(STEEL, LOWER)).ics(PATCH, OBSERVERS.x, OBSERVERS.s)[:, 2] / PATCH.area
    scale = np.max(np.abs(a[2]))
    error = np.max(np.abs(result.raw[:, 2] - a)) / scale
    assert error == pytest.approx(OFF * result.cells.smallest**3, rel=1e-9)
    assert np.max(result.c.mesh_error[2, 2]) / scale <= tolerance
    assert set(result.models) >= {"fine", "coarse"}
    if tolerance == 1e-3:
        with pytest.raises(NotConverged, match="`most_unknowns`"):
            c_of(tolerance, most_unknowns=result.models["fine"].unknowns // 2)
