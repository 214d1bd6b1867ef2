"""What models will take: the laws of the plan, and integrals that are known."""

from dataclasses import replace

import numpy as np
import pytest

from femic.reference.engine import Points, Request
from femic.reference.engines import HARMONIC, SOLID
from femic.reference.harmonic import engine as plan
from femic.reference.harmonic.engine import build_section, expected_samples
from femic.reference.meshing import Cells
from femic.reference.solid import engine as solid_plan
from geometries.bodies import Body, Domain
from geometries.contours import arc, plane
from geometries.patches import Load, Patch
from geometries.surfaces import LOWER
from tests.femic.reference.conftest import STEEL
from tests.femic.reference.small_model import TASK

LOADS = tuple(Load(Patch(0.4, 0.5, s), direction) for s in (0.0, 2.0, -2.0) for direction in range(3))


def with_cells(factor):
    return replace(TASK.request, cells=TASK.request.cells.scaled(factor))


def with_law(monkeypatch, **constants):
    """The plan with some of its measured constants."""
    for name, value in constants.items():
        monkeypatch.setattr(plan, name, value)


def unknowns_of(request):
    return 3 * build_section(request).mesh.doflocs.shape[1]


def start_of(request):
    return 2 * plan.START + plan.PER_UNKNOWN * (unknowns_of(request) + unknowns_of(request.coarser))


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
    times = {}
    for workers in (1, 4, 8):
        result = HARMONIC.expected_cost(TASK.request, workers)
        of_processes = plan.START_OF_PROCESSES if least == 0 and workers > 1 else 0.0
        times[workers] = result.seconds - start_of(TASK.request) - of_processes
    assert times[1] == pytest.approx(4 * getattr(plan, speed_up) * times[4])
    assert times[4] == pytest.approx(2 * times[8])


def test_unknowns_are_those_of_the_mesh_and_memory_grows_with_them():
    result, finer = (
        HARMONIC.expected_cost(replace(TASK.request, cells=TASK.request.cells.scaled(f)), 1) for f in (1, 0.5)
    )
    assert result.unknowns == unknowns_of(TASK.request)
    assert result.memory == pytest.approx(200 + 0.012 * result.unknowns)
    assert finer.unknowns > 1.5 * result.unknowns
    assert not result.half_section


def test_each_process_takes_memory_and_no_more_than_eight_are_begun(monkeypatch):
    monkeypatch.setattr(plan, "UNKNOWNS_FOR_PROCESSES", 0)
    alone, two, eight, many = (HARMONIC.expected_cost(TASK.request, n) for n in (1, 2, 8, 64))
    assert alone.memory == pytest.approx(200 + 0.012 * alone.unknowns)
    assert two.memory == pytest.approx(200 + 2 * (200 + 0.006 * two.unknowns))
    assert many == eight


@pytest.mark.parametrize("contour", [arc(10.0, 0.3, 0.4), plane()])
def test_each_wavenumber_is_factored_once_and_about_half_of_them_with_coarser_cells(monkeypatch, contour):
    """Whether even and odd parts are apart or not; loads at s and -s are one column of a half section."""
    with_law(monkeypatch, FACTOR=1.0, FACTOR_GROWTH=0.0, START=0.0, PER_UNKNOWN=0.0)
    asked = replace(TASK.request, loads=LOADS, body=replace(TASK.request.body, contour=contour))
    result = HARMONIC.expected_cost(asked, 1)
    assert result.seconds == sum(solutions(asked))
    assert result.half_section == contour.symmetric
    assert result.fields == (6 if contour.symmetric else 9)


def test_costs_of_unknowns_follow_their_power(monkeypatch):
    with_law(monkeypatch, START=0.0, PER_UNKNOWN=0.0, FACTOR=1.0, FACTOR_GROWTH=1.5)
    for factor in (1, 0.5):
        asked = with_cells(factor)
        fine, coarser = solutions(asked)
        expected = fine * unknowns_of(asked) ** 1.5 + coarser * unknowns_of(asked.coarser) ** 1.5
        assert HARMONIC.expected_cost(asked, 1).seconds == pytest.approx(expected)


def test_wavenumbers_are_those_that_a_half_space_would_take():
    result = HARMONIC.expected_cost(TASK.request, 1)
    assert result.wavenumbers == len(expected_samples(TASK.request).k)
    finer = HARMONIC.expected_cost(replace(TASK.request, accuracy=TASK.request.accuracy / 1000), 1)
    assert finer.wavenumbers > result.wavenumbers


UNIFORM = Cells(2.0, 1e-9, 1e-9)


def solid(contour, half_length=30.0, cells=UNIFORM, directions=(2,)):
    body = Body(LOWER, contour, STEEL, Domain(40.0, half_length))
    loads = tuple(Load(Patch(0.3, 0.5), direction) for direction in directions)
    return Request(body, loads, Points(np.array([1.0]), np.array([0.5])), cells, "multigrid")


@pytest.mark.parametrize(("contour", "share"), [(plane(), 0.5), (arc(1e4, 1e-4, 2e-4), 1.0)])
def test_cells_of_one_size_fill_the_body(contour, share):
    """Half of a cylinder of radius 40 mm, 30 mm of it along +x; half of that where it is symmetric in y."""
    volume = share * np.pi * 40.0**2 / 2 * 30.0
    cubes = solid_plan._cubes(solid(contour))
    assert cubes == pytest.approx(volume / 2.0**3, rel=0.05)  # of 40 000 random points
    assert SOLID.expected_cost(solid(contour), 1).unknowns == round(4.2 * 5.4 * cubes)


def test_each_field_of_a_solid_is_solved():
    one, three = (SOLID.expected_cost(solid(plane(), directions=d), 1) for d in ((2,), (0, 1, 2)))
    assert (one.fields, three.fields) == (1, 3)
    assert three.seconds - one.seconds == pytest.approx(2 * 3e-5 * one.unknowns)
    assert one.seconds == pytest.approx((6e-5 + 3e-5) * one.unknowns)
    assert one.memory == pytest.approx(200 + 0.0065 * one.unknowns)


def test_smaller_cells_at_the_points_cost_more():
    even, graded = (
        solid_plan._cubes(solid(plane(), cells=cells)) for cells in (UNIFORM, Cells(2.0, 0.2, 0.2))
    )
    assert graded < even / 5


@pytest.mark.parametrize("contour", [plane(), arc(1e4, 1e-4, 2e-4)])
def test_points_cost_the_same_on_the_other_side_of_a_plane_of_symmetry(contour):
    asked = replace(
        solid(contour, cells=Cells(0.5, 0.3, 0.3)), points=Points(np.array([4.0]), np.array([7.0]))
    )
    cubes = solid_plan._cubes(asked)
    in_x = replace(asked, points=Points(np.array([-4.0]), np.array([7.0])))
    in_y = replace(asked, points=Points(np.array([4.0]), np.array([-7.0])))
    assert solid_plan._cubes(in_x) == pytest.approx(cubes, rel=1e-12)
    assert (abs(solid_plan._cubes(in_y) / cubes - 1) < 1e-12) == contour.symmetric
