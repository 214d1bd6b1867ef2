"""Rolling of a pair: the distance of the displaced wheel, and the work of friction where little slides."""

from dataclasses import replace
from functools import cache

import numpy as np
import pytest

from femic.contact.estimates import Measured, errors
from femic.contact.friction.motion import Creepages
from femic.contact.loading import Loading
from femic.contact.motions import pair_in_motion
from femic.contact.motions.compression import OF_COMPRESSION
from femic.contact.motions.rolling import (
    EDGE_SHARE,
    OF_CURVE,
    OF_ROLLING,
    Continuation,
    CreepForceCurve,
    displaced,
    displaced_numbers,
    measured_rolling,
)
from femic.contact.pairs.grids import grids_of
from femic.contact.pairs.ics import approximation
from femic.contact.pairs.pair_on_grid import pair_on_grid
from femic.contact.pairs.pair_with_friction import Linearisation
from femic.contact.pairs.quantities import kinds, measured
from femic.contact.rolling import compressed
from femic.results.friction import compute_with_friction
from femic.scenes.load import load_scene
from geometries.patches import Grid
from tests.femic.contact.wheel_on_rail import scene

LOAD = 1e4
SCENE = scene(
    10.3, motion="rolling", loads=[LOAD], longitudinal=[-1e-3, 0.0, 1e-3], friction=[0.3], ics=["Bhat"]
)
GRID = Grid(24, 36, 0.7, 0.5)


def path_of(friction, of=SCENE, grid=GRID):
    pair = pair_in_motion(of.contact_problem, pair_on_grid(of.contact_problem, grid))
    problem = pair.frictional(approximation(pair.on_grid, "Bhat"), friction)
    return Continuation(pair, pair.rolling(problem), "a path")


def beside_the_crown(motion, shift, **keys):
    """A scene with a wheel beside the crown, and the grid of its contact."""
    keys = {"motion": motion, "loads": [5e4], "friction": [0.3], "ics": ["Bhat"], "shift": shift} | keys
    of = scene(10.4, 500.0, elements=16, **keys)
    return of, grids_of(of.contact_problem)[0][0]


def check_part(on_grid, fine, exact, quantities, names):
    """What linearisation does without friction tells what it does with it: no less, and not 8 times more."""
    operator = approximation(on_grid, "Bhat")
    part = Linearisation.measure(on_grid, operator, 5e4).part(fine, kinds(quantities))
    for name in names:
        away = abs(exact.numbers[name] - fine.numbers[name])
        assert away <= 1.1 * part[name], name
        assert part[name] <= 8 * away, name


def test_zero_friction_gives_the_contact_with_the_exact_distance():
    """Pressures and approach, by the fixed point of contacts that know nothing of tangential tractions."""
    along = path_of(0.0)
    linear = along.solve(0.0, None)
    result, on_grid = displaced(along, linear).contact, along.pair.on_grid
    exact = on_grid.solve_in_place(on_grid.operator("Bhat"), Loading(LOAD), exact=True)
    assert result.approach == pytest.approx(exact.approach, rel=1e-5)
    np.testing.assert_allclose(result.p[..., 2], exact.p, atol=1e-4 * exact.p.max())
    assert abs(np.max(result.p) / np.max(linear.contact.p) - 1) > 1e-3


def test_distance_is_evaluated_at_the_contacts_own_approach():
    along = path_of(0.3)
    on_grid, result = along.pair.on_grid, displaced(along, along.solve(0.0, None))
    approach = result.contact.approach
    distance = on_grid.distance_at(approach) + approach * on_grid.cosine
    problem = replace(along.problem, problem=replace(along.problem.problem, distance=distance))
    again = problem.contact(result.creepages, Loading(LOAD))
    assert again.contact.approach == pytest.approx(approach, rel=1e-4)
    assert again.contact.force == pytest.approx(result.contact.force, abs=1e-4 * 0.3 * LOAD)


@pytest.mark.parametrize(("shift", "xi"), [(0.03, 0.0), (0.03, 1e-3), (0.2, 0.0)])
def test_what_linearisation_does_without_friction_tells_what_it_does_in_rolling(shift, xi):
    """Forces, work and patch, with the exact distance."""
    along = path_of(0.3, *beside_the_crown("rolling", shift, longitudinal=[-1e-3, 0.0, 1e-3]))
    linear = along.at(xi, None)
    fine, exact = along.measured(linear), along.measured(displaced(along, linear))
    names = "F_x", "F_y", "M_x", "M_z", "dissipation", "p_max", "b", "angle"
    check_part(along.pair.on_grid, fine, exact, OF_ROLLING, names)


def test_what_linearisation_does_without_friction_tells_what_it_does_in_compression():
    """With the distance at the last approach."""
    of, grid = beside_the_crown("compression", 0.03)
    pair = pair_in_motion(of.contact_problem, pair_on_grid(of.contact_problem, grid))
    problem = pair.frictional(approximation(pair.on_grid, "Bhat"), 0.3)
    loads = [Loading(2.5e4), Loading(5e4)]
    *_, linear = compressed(problem, loads)
    exact = linear
    for _ in range(2):
        distance = pair.on_grid.distance_at(exact.approach) + exact.approach * pair.on_grid.cosine
        *_, exact = compressed(replace(problem, distance=distance), loads)
    fine, other = (measured(pair.on_grid, each, OF_COMPRESSION) for each in (linear, exact))
    check_part(pair.on_grid, fine, other, OF_COMPRESSION, ("F_y", "M_x", "p_max", "b", "angle"))


@pytest.mark.parametrize(
    ("motion", "keys"),
    [
        ("rolling", {"longitudinal": [-1e-3, 0.0, 1e-3]}),
        ("transient", {"creepage": 1e-3, "distance": 2.0}),
        ("compression", {}),
    ],
)
def test_estimates_of_all_motions_have_the_part_of_the_linearised_distance(motion, keys, monkeypatch):
    """A part that is larger than all others is seen in each of them."""
    large = 1e9
    monkeypatch.setattr(Linearisation, "part", lambda _, __, of_all: dict.fromkeys(of_all, large))
    monkeypatch.setattr(Linearisation, "part_of_curve", lambda *_: dict.fromkeys(OF_CURVE, large))
    of = scene(14.0, 500.0, motion=motion, loads=[2e3], friction=[0.3], ics=["A"], elements=8, **keys)
    dataset = compute_with_friction(of)
    names = [name for name in OF_COMPRESSION if f"estimate_{name}" in dataset]
    names += [name for name in OF_CURVE if motion == "rolling"]
    assert len(names) >= 9
    for name in names:
        assert np.all(dataset[f"estimate_{name}"] >= large), name


def test_displacement_on_a_plane_changes_nothing():
    """The distance of a plane and a paraboloid is linear in the approach, to the square of slopes."""
    of = load_scene(
        "flat",
        {
            "upper": {"contour": {"kind": "arc", "radius": 400.0, "flank_inclination_deg": 3.0}},
            "contact": {"motion": "compression", "loads": [1.0]},
        },
    )
    on_grid = pair_on_grid(of.contact_problem, Grid(8, 6, 0.4, 0.6))
    moved = on_grid.distance_at(0.01) + 0.01 * on_grid.cosine
    np.testing.assert_allclose(moved, on_grid.distance, atol=1e-12)


def test_file_holds_the_changes_by_displacement():
    dataset = compute_with_friction(SCENE).isel(friction=0, ics=0)
    sizes = (float(np.diff(dataset[name])[0]) for name in ("x", "s"))
    along = path_of(0.3, grid=Grid(dataset.sizes["x"], dataset.sizes["s"], *sizes))
    result = displaced(along, along.solve(0.0, None)).contact
    assert float(dataset.displaced_xi) == 0.0
    assert float(dataset.displaced_F_x) == pytest.approx(result.force[0], abs=1e-4 * 0.3 * LOAD)
    changed = float(dataset.displaced_F_x - dataset.F_x.sel(xi=0.0))
    moved = float(dataset.displaced_zero_creepage - dataset.zero_creepage)
    assert moved == pytest.approx(-changed / float(dataset.slope), rel=1e-3)
    assert moved != 0.0


@pytest.mark.parametrize("followers", [2, 1])
def test_contacts_of_different_forms_are_not_compared(followers, monkeypatch):
    """What fewer elements at the leading edge change is not what the distance changes."""
    along = path_of(0.3)
    first = along.solve(0.0, None)
    curve = CreepForceCurve({}, {}, Measured({"zero_creepage": -1e-3, "slope": 1e7}, {}, {}), first)
    simpler = replace(first.contact, motion=replace(first.contact.motion, followers=followers))
    monkeypatch.setattr("femic.contact.motions.rolling.displaced", lambda *_: replace(first, contact=simpler))
    known = displaced_numbers(along, curve)
    assert np.isnan(known["zero_creepage"]) == np.isnan(known["p_max"]) == (followers != 2)


# ---- the work of friction where little slides: what grids miss of it is in its estimate


def estimated_work(of):
    """The estimated error of work if larger elements have the same numbers."""
    return errors(kinds(OF_ROLLING), of, [of])["dissipation"]


ON_20_BY_28 = Grid(20, 28, 0.7, 0.6)


@cache
def rolled(xi, friction=0.3):
    """The grid's bodies, the problem and the contact at a creepage."""
    along = path_of(friction, grid=ON_20_BY_28)
    return along.pair.on_grid, along.problem, along.problem.contact(Creepages(xi), Loading(LOAD))


def test_forces_that_creepages_follow_from_are_exact():
    """A wheel that rolls freely has no longitudinal force on any grid; its lateral one is computed."""
    on_grid, rolling, contact = rolled(1e-4)
    free = rolling.contact(Creepages(lateral=2e-4), Loading(LOAD), forces={"longitudinal": 0.0})
    known = measured_rolling(on_grid, rolling, free)
    assert "F_x" in known.exact
    assert not {"F_y", "p_max", "approach"} & set(known.exact)
    assert "F_x" not in measured_rolling(on_grid, rolling, contact).exact


def test_the_estimate_of_work_is_at_least_what_slip_misses():
    """The work on the rigid motion converges faster: it is the judge."""
    on_grid, rolling, contact = rolled(1e-4)
    known, plain = measured_rolling(on_grid, rolling, contact), measured(on_grid, contact.contact, OF_ROLLING)
    missed = abs(rolling.power(contact) - rolling.climbing(contact) - known.numbers["dissipation"])
    assert missed == rolling.missed_work(contact) > 0.3 * known.numbers["dissipation"]
    assert estimated_work(plain) < 0.9 * missed  # without it, grids that agree would hide it
    # and a share of the work at the edge
    assert missed <= estimated_work(known) < (1.01 + EDGE_SHARE / 0.3) * missed
    assert known.numbers == plain.numbers
    assert known.scales == plain.scales
    assert {name for name in plain.floors if known.floors[name] != plain.floors[name]} == {"work"}


def test_missed_work_has_no_sign():
    _, rolling, contact = rolled(1e-4)
    tangential = contact.contact.tangential
    work = np.sum(contact.contact.dissipation) * rolling.problem.grid.area
    on_body = rolling.power(contact) - rolling.climbing(contact)
    for factor in (0.0, 2 * on_body / work):  # times the work of slip: none, and twice that on the body
        other = replace(contact.contact, tangential=replace(tangential, slip=factor * tangential.slip))
        assert rolling.missed_work(replace(contact, contact=other)) == pytest.approx(on_body)


def test_where_all_slides_the_slip_misses_little():
    on_grid, rolling, contact = rolled(0.05)
    assert rolling.missed_work(contact) < 2e-3 * rolling.power(contact)
    known = measured_rolling(on_grid, rolling, contact)
    assert known.floors["work"] < 2e-3 + EDGE_SHARE * 0.3  # shares of all of it; less than 0.3 is at the edge


def test_without_friction_there_is_no_work():
    known = measured_rolling(*rolled(1e-3, 0.0))
    assert known.numbers["dissipation"] == pytest.approx(0.0, abs=1e-12)
    assert np.isfinite(list(known.floors.values())).all()
