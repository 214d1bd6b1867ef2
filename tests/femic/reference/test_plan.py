"""What models are expected to take: wavenumbers, cells, seconds and memory; the models of a run."""

from dataclasses import replace

import numpy as np
import pytest

from compare.pages.matrix import cost_table
from femic.reference.engine import Cost, ExpectedCost, Points, Request
from femic.reference.engines import ENGINES, HARMONIC, SOLID
from femic.reference.harmonic import engine as plan
from femic.reference.harmonic.engine import build_section, expected_samples, solve
from femic.reference.harmonic.request import HarmonicRequest
from femic.reference.meshing import Cells
from femic.reference.refinement import ModelPlan, total_seconds
from femic.reference.solid import engine as solid_plan
from femic.results.ics import run_plans
from femic.scenes.load import load_scene
from geometries.bodies import Body, Domain
from geometries.contours import arc, ellipse, plane
from geometries.patches import Load, Patch
from geometries.surfaces import LOWER, UPPER
from tests.femic.reference.conftest import STEEL
from tests.femic.reference.small_model import TASK

# --- wavenumbers ---------------------------------------------------------------------------------------

STEEP = np.radians(60)
OBSERVED = Points(np.zeros(7), np.array([-8.0, -1.6, -0.3, 0.0, 0.7, 1.6, 8.0]))
CASES = {  # (side, contour, R_roll, half-sides, accuracy as a share of 1 / (2 pi G 8 mm))
    "plane": (LOWER, plane(), np.inf, (0.2, 0.3), 1e-3),
    "plane, roughly": (LOWER, plane(), np.inf, (0.2, 0.3), 3e-2),
    "plane, small patch": (LOWER, plane(), np.inf, (0.004, 0.006), 1e-3),
    "plane, long patch": (LOWER, plane(), np.inf, (1.0, 0.01), 1e-3),
    "rail, wide patch": (LOWER, ellipse(13.0, 6.5, STEEP, STEEP), np.inf, (0.1, 1.0), 1e-3),
    "small wheel": (UPPER, arc(10.0, STEEP, STEEP), 50.0, (0.3, 0.2), 1e-3),
    "large wheel": (UPPER, arc(10.0, STEEP, STEEP), 1e5, (0.3, 0.2), 1e-3),
}
MORE = ("plane, long patch", "plane, small patch", "large wheel")


def request(case, accuracy=None):
    side, contour, rolling_radius, (a, b), share = CASES[case]
    body = Body(side, contour, STEEL, Domain(320.0, np.inf), rolling_radius)
    loads = tuple(Load(Patch(a, b), direction) for direction in (1, 2))
    accuracy = share / (2 * np.pi * STEEL.G * 8.0) if accuracy is None else accuracy
    return HarmonicRequest(body, loads, OBSERVED, Cells(b, 1.2, 1.2), accuracy)


@pytest.mark.parametrize(
    "case", [pytest.param(case, marks=pytest.mark.slow) if case in MORE else case for case in CASES]
)
def test_as_many_wavenumbers_are_expected_as_are_taken(case):
    asked = request(case)
    taken, expected = len(solve(asked).samples.k), len(expected_samples(asked).k)
    if "plane" in case:
        assert abs(expected - taken) <= 3, (expected, taken)  # an interval next to the far arc's effect
    assert 0.7 < expected / taken < 1.3, (expected, taken)


def test_tighter_accuracy_takes_more_wavenumbers_and_may_differ_by_observer():
    def expected(accuracy):
        return len(expected_samples(request("plane", accuracy)).k)

    assert expected(1e-9) < expected(1e-11)
    each = np.full((1, 1, len(OBSERVED.s)), 1e-9)
    assert expected(each) == expected(1e-9)
    each[..., 3] = 1e-11
    assert expected(1e-9) < expected(each) <= expected(1e-11)


# --- the harmonic engine -------------------------------------------------------------------------------

LOADS = tuple(Load(Patch(0.4, 0.5, s), direction) for s in (0.0, 2.0, -2.0) for direction in range(3))
FINER = replace(TASK.request, cells=TASK.request.cells.scaled(0.5))


def unknowns_of(request):
    return 3 * build_section(request).mesh.doflocs.shape[1]


def solutions(request):
    """Numbers of factorisations with the request's cells and with coarser ones."""
    samples = expected_samples(request)
    coarser = int(np.sum(~samples.last))
    assert 0 < coarser < len(samples.k)
    return len(samples.k), coarser


@pytest.mark.parametrize(("least", "speed_up"), [(10**9, "BY_THREADS"), (0, "BY_PROCESSES")])
def test_workers_share_the_eliminations(monkeypatch, least, speed_up):
    """A share of a core each, and one alone is one; mesh, assembly and start are not shared."""
    monkeypatch.setattr(plan, "UNKNOWNS_FOR_PROCESSES", least)
    unknowns = unknowns_of(TASK.request) + unknowns_of(TASK.request.coarser)
    start, times = 2 * plan.START + plan.PER_UNKNOWN * unknowns, {}
    for workers in (1, 4, 8):
        result = HARMONIC.expected_cost(TASK.request, workers)
        of_processes = plan.START_OF_PROCESSES if least == 0 and workers > 1 else 0.0
        times[workers] = result.seconds - start - of_processes
    assert times[1] == pytest.approx(4 * getattr(plan, speed_up) * times[4])
    assert times[4] == pytest.approx(2 * times[8])


def test_memory_grows_with_the_unknowns_of_the_mesh_and_with_each_of_at_most_eight_processes(monkeypatch):
    result, finer = (HARMONIC.expected_cost(asked, 1) for asked in (TASK.request, FINER))
    assert result.unknowns == unknowns_of(TASK.request)
    assert result.memory == pytest.approx(200 + 0.012 * result.unknowns)
    assert finer.unknowns > 1.5 * result.unknowns
    assert not result.half_section
    monkeypatch.setattr(plan, "UNKNOWNS_FOR_PROCESSES", 0)
    two, eight, many = (HARMONIC.expected_cost(TASK.request, n) for n in (2, 8, 64))
    assert two.memory == pytest.approx(200 + 2 * (200 + 0.006 * two.unknowns))
    assert many == eight


@pytest.mark.parametrize("contour", [arc(10.0, 0.3, 0.4), plane()])
def test_each_wavenumber_is_factored_once_and_about_half_of_them_with_coarser_cells(monkeypatch, contour):
    """At a cost that grows like a power of the unknowns.

    Whether even and odd parts are apart or not; loads at s and -s are one column of a half section.
    """
    asked = replace(TASK.request, loads=LOADS, body=replace(TASK.request.body, contour=contour))
    fine, coarser = solutions(asked)
    for name, value in {"START": 0.0, "PER_UNKNOWN": 0.0, "FACTOR": 1.0, "FACTOR_GROWTH": 1.5}.items():
        monkeypatch.setattr(plan, name, value)
    result = HARMONIC.expected_cost(asked, 1)
    expected = fine * unknowns_of(asked) ** 1.5 + coarser * unknowns_of(asked.coarser) ** 1.5
    assert result.seconds == pytest.approx(expected)
    assert result.wavenumbers == fine
    assert result.half_section == contour.symmetric
    assert result.fields == (6 if contour.symmetric else 9)


# --- the solid engine ----------------------------------------------------------------------------------

UNIFORM = Cells(2.0, 1e-9, 1e-9)


def solid(contour, cells=UNIFORM, directions=(2,), point=(1.0, 0.5)):
    body = Body(LOWER, contour, STEEL, Domain(40.0, 30.0))
    loads = tuple(Load(Patch(0.3, 0.5), direction) for direction in directions)
    return Request(body, loads, Points(*np.array(point)[:, None]), cells, "multigrid")


@pytest.mark.parametrize(("contour", "share"), [(plane(), 0.5), (arc(1e4, 1e-4, 2e-4), 1.0)])
def test_cells_of_one_size_fill_the_body(contour, share):
    """Half of a cylinder of radius 40 mm, 30 mm of it along +x; half of that where it is symmetric in y."""
    volume = share * np.pi * 40.0**2 / 2 * 30.0
    cubes = solid_plan._cubes(solid(contour))
    assert cubes == pytest.approx(volume / 2.0**3, rel=0.05)  # of 40 000 random points
    assert SOLID.expected_cost(solid(contour), 1).unknowns == round(4.2 * 5.4 * cubes)
    assert solid_plan._cubes(solid(contour, Cells(2.0, 0.2, 0.2))) < cubes / 5


def test_each_field_of_a_solid_is_solved():
    one, three = (SOLID.expected_cost(solid(plane(), directions=d), 1) for d in ((2,), (0, 1, 2)))
    assert (one.fields, three.fields) == (1, 3)
    assert three.seconds - one.seconds == pytest.approx(2 * 3e-5 * one.unknowns)
    assert one.seconds == pytest.approx((6e-5 + 3e-5) * one.unknowns)
    assert one.memory == pytest.approx(200 + 0.0065 * one.unknowns)


@pytest.mark.parametrize("contour", [plane(), arc(1e4, 1e-4, 2e-4)])
def test_points_cost_the_same_on_the_other_side_of_a_plane_of_symmetry(contour):
    cubes, in_x, in_y = (
        solid_plan._cubes(solid(contour, Cells(0.5, 0.3, 0.3), point=point))
        for point in ((4.0, 7.0), (-4.0, 7.0), (4.0, -7.0))
    )
    assert in_x == pytest.approx(cubes, rel=1e-12)
    assert (abs(in_y / cubes - 1) < 1e-12) == contour.symmetric


# --- the models of a run -------------------------------------------------------------------------------


def step(engine, seconds):
    cost = ExpectedCost(1000, 20, 3, half_section=True, seconds=seconds, memory=100.0)
    return ModelPlan("a model", ENGINES[engine], 1.0, 100.0, "infinite", cost)


@pytest.mark.parametrize(("workers", "expected"), [(1, 3 + 5 + 8 + 4), (2, 3 + 5 + 6), (4, 3 + 5 + 3)])
def test_models_of_the_solid_engine_share_the_workers_those_of_the_harmonic_follow_each_other(
    workers, expected
):
    """A harmonic model uses all workers by itself: its own seconds already count them."""
    model_plans = [step("harmonic", 3.0), step("solid", 8.0), step("harmonic", 5.0), step("solid", 4.0)]
    assert total_seconds(model_plans, workers) == pytest.approx(expected)
    assert total_seconds([], workers) == 0


@pytest.mark.parametrize("check", [False, True])
def test_a_run_plans_the_models_of_the_scene_and_those_of_its_check(check):
    scene = load_scene("flat", {"bodies": ["lower"], "engine": {"check": check, "tolerance": 0.1}})
    cells = {"lower, fine": 1.0}
    if check:
        cells |= {"check, lower, fine": 1.0, "check, lower, coarse": 1.5, "check, lower, small": 1.5}
    assert {one.name: one.cells for one in run_plans(scene, 1)} == pytest.approx(cells)


@pytest.mark.parametrize(
    ("engine", "solver", "told"),
    [("harmonic", "direct, 27 wavenumbers", "20 / 27"), ("solid", "multigrid", "20 / –")],
)
def test_wavenumbers_are_shown_beside_those_planned(engine, solver, told):
    cost = Cost(1200, 100, solver, (), 1e-12, {"mesh": 1.0, "solution": 2.0}, 150.0)
    (row,) = cost_table([step(engine, 4.0)], {"a model": cost, "another": cost}).rows
    assert row.cells == ["1,000 / 1,200", told, "4 / 3", "100 / 150"]
