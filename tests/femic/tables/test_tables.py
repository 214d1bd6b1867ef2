"""Tables of creep forces: contacts in them, their limits and mirror images, and how accurate they are."""

from dataclasses import replace
from fractions import Fraction

import numpy as np
import pytest

import femic
from femic.cache.store import Store
from femic.contact.exact.creepage_coefficients import creepage_coefficients
from femic.reference.run_options import RunOptions
from femic.results import tables
from femic.scenes.load import load_scene
from femic.tables import columns, refinement
from femic.tables.columns import CONTACT, FORCES, Place, Slip, creepages, solve_column
from femic.tables.refinement import Contacts, all_contacts, first_nodes, refined_table
from femic.tables.specification import TableSpecification
from geometries.errors import Failure, WrongInput

STEEL = femic.Material(E=210e3, nu=0.3)
RAIL = femic.Body(femic.arc(300.0, 30.0), STEEL)
WHEEL = femic.Body(femic.arc(330.0, 25.0), STEEL, rolling_radius=460.0)
LOAD, FRICTION = 40e3, 0.3
HERE = Place(0.0, LOAD, FRICTION)


def problem(folder, text, ics="A", **table):
    """The contact problem of a scene's table."""
    (folder / "own.toml").write_text(text)
    scene = load_scene(folder / "own.toml")
    scene = replace(scene, table=TableSpecification(loads=(LOAD,), ics=ics, **table))
    return tables.rolling_scene(scene).contact_problem


WHEEL_ON_RAIL = """
[lower]
E = 210e3
nu = 0.3
contour = { kind = "arc", radius = 300.0, flank_inclination_deg = 30.0 }
[upper]
E = 210e3
nu = 0.3
contour = { kind = "arc", radius = 330.0, flank_inclination_deg = 25.0 }
rolling_radius = 460.0
[contact]
flanks = false
"""
BALL_ON_PLANE = """
reference_length = 100.0
[lower]
E = 210e3
nu = 0.3
contour = { kind = "plane" }
[upper]
E = 210e3
nu = 0.3
contour = { kind = "arc", radius = -300.0, flank_inclination_deg = 20.0 }
rolling_radius = 300.0
"""


def column(problem, place, slips, elements=12):
    return solve_column(problem, place, slips, elements, RunOptions(1))


@pytest.fixture
def wheel(tmp_path):
    return problem(tmp_path, WHEEL_ON_RAIL, "Bhat")


@pytest.fixture
def ball(tmp_path):
    return problem(tmp_path, BALL_ON_PLANE)


# --- contacts ---


def test_without_creepage_nothing_acts_and_far_beyond_saturation_friction_opposes_slip(ball):
    turns = [Fraction(k, 8) for k in range(8)]
    found = column(ball, HERE, [Slip(0.0, Fraction(0), 0.0), *(Slip(0.0, turn, 1.0) for turn in turns)])
    still, *sliding = found.shares
    f_x, f_y, f_n, m_n, p, w = range(6)
    assert still[[f_x, f_y, m_n, w]] == pytest.approx(0, abs=4e-3)  # spherical: circles roll unlike
    assert still[[f_n, p]] == pytest.approx(1, abs=1e-3)
    for turn, shares in zip(turns, sliding, strict=True):
        along, across = np.cos(2 * np.pi * turn), np.sin(2 * np.pi * turn)
        assert shares[[f_x, f_y, f_n]] == pytest.approx([along, -across, 1], abs=2e-3)
        assert shares[w] == pytest.approx(1, abs=2e-3)


def test_small_creepages_follow_kalkers_linear_theory(ball):
    small = 0.02
    slips = [Slip(0.0, Fraction(k, 4), small) for k in (0, 1)]
    found = column(ball, HERE, slips, elements=24)
    kalker = creepage_coefficients(1.0, 1.0, 0.3)
    for shares, coefficient, sign in (
        (found.shares[0][0], kalker.C11, 1),
        (found.shares[1][1], kalker.C22, -1),
    ):
        ratio = coefficient / columns.CREEP_COEFFICIENT  # of the linear force to that of the scale
        expected = 3 * small / (1 - small) * ratio
        # a part slides already: 3 m / 3 at m = 0.06
        assert sign * shares == pytest.approx(expected, rel=0.06)


def test_quantities_without_friction_are_those_of_hertz(ball):
    found = column(ball, HERE, []).contact
    modulus = 210e3 / (1 - 0.09) / 2
    a = (3 * LOAD * 300.0 / 4 / modulus) ** (1 / 3)
    assert found["half_size"] == pytest.approx(a, rel=0.01)
    assert found["approach"] == pytest.approx(a**2 / 300, rel=0.01)
    assert found["p_max"] == pytest.approx(1.5 * LOAD / np.pi / a**2, rel=0.01)
    assert found["normal_force"] == pytest.approx(LOAD, rel=1e-6)
    assert [found[name] for name in ("contact_angle", "y")] == pytest.approx([0, 0], abs=1e-9)


@pytest.mark.parametrize("shift", [0.0, 3.0])
def test_contacts_are_those_of_a_solver_that_is_kept(wheel, shift):
    """Another way to the same contacts, which takes the linearised distance."""
    slips = [Slip(0.5, Fraction(1, 8), 0.3), Slip(-1.0, Fraction(5, 8), 0.5), Slip(0.0, Fraction(1, 4), 0.1)]
    found = column(wheel, Place(shift, LOAD, FRICTION), slips)
    table = tables.Table(
        {
            "shift": [shift],
            "load": [LOAD],
            "friction": [FRICTION],
            "spin": [0.0],
            "angle": [0.0],
            "creepage": [0, 1],
        },
        {name: np.full((1, 1), value) for name, value in found.contact.items()},
        [name for name, entry in CONTACT.items() if entry[1] == "log"],
        {name: np.zeros((1, 1, 1, 1, 1, 2)) for name in FORCES},
    )
    setup = femic.ContactSetup(elements=12, shift=shift, flanks=False)
    solver = femic.ContactSolver(femic.Pair(WHEEL, RAIL), LOAD, "Bhat", setup)
    approach = solver.solve(LOAD).approach
    assert found.contact["approach"] == pytest.approx(approach, rel=2e-3)
    for slip, shares in zip(slips, found.shares, strict=True):
        own = creepages(found.contact, FRICTION, slip)
        there = solver.solve(
            approach=approach,
            friction=FRICTION,
            longitudinal=own.longitudinal,
            lateral=own.lateral,
            spin=own.spin,
        )
        table.shares = lambda *_, shares=shares: dict(zip(FORCES, shares, strict=True))
        here = table.forces(shift, LOAD, FRICTION, own.longitudinal, own.lateral, own.spin)
        scale = FRICTION * LOAD
        assert [here["F_x"], here["F_y"], here["F_z"]] == pytest.approx(there.force, abs=0.01 * scale)
        assert here["p_max"] == pytest.approx(there.numbers["p_max"], rel=3e-3)
        assert here["work"] == pytest.approx(there.numbers["work"], rel=0.02)
        y, z = found.contact["y"], found.contact["z"]
        moment = there.moment - np.cross([0.0, y, z], there.force)
        angle = found.contact["contact_angle"]
        about_normal = moment @ [0.0, -np.sin(angle), np.cos(angle)]
        assert here["M_n"] == pytest.approx(about_normal, abs=0.02 * scale * found.contact["half_size"])


def test_patches_far_apart_give_what_one_grid_gives(tmp_path, monkeypatch):
    s = np.linspace(-12, 12, 97)
    np.savetxt(tmp_path / "bump.txt", np.c_[s, 0.12 * np.exp(-((s / 4.0) ** 2))])
    text = WHEEL_ON_RAIL.replace("330.0", "500.0") + f'extra_gap = "{tmp_path / "bump.txt"}"\n'
    split = problem(tmp_path, text)
    slips = [Slip(k, Fraction(turn, 8), u) for k in (0.0, 0.5) for turn in (0, 3) for u in (0.3, 0.7)]
    monkeypatch.setattr(columns, "BESIDE", 4)
    parts, kept = [], columns._patches

    def noted(*arguments):
        parts.append(kept(*arguments))
        return parts[-1]

    monkeypatch.setattr(columns, "_patches", noted)
    apart = column(split, HERE, slips, 8)
    assert len(parts[-1]) == 2
    monkeypatch.setattr(columns, "_patches", lambda problem, _, p: {columns.Box.whole(p.shape): problem})
    whole = column(split, HERE, slips, 8)
    np.testing.assert_allclose(apart.shares[:, :2], whole.shares[:, :2], atol=0.01)
    np.testing.assert_allclose(apart.shares[:, 2:], whole.shares[:, 2:], rtol=0.01, atol=0.01)


# --- symmetry ---


def test_mirrored_contacts_are_those_that_are_solved(wheel):
    slips = [Slip(0.4, Fraction(1, 8), 0.3), Slip(-0.4, Fraction(3, 8), 0.6), Slip(0.0, Fraction(5, 8), 0.2)]
    options = RunOptions(1)
    mirrored, solved = (Contacts(wheel, 10, symmetric, options, map) for symmetric in (True, False))
    for place in (HERE, HERE._replace(shift=-2.0)):
        for contacts in (mirrored, solved):
            contacts.solve({place: slips}, "")
        assert place in solved.shares
        for slip in slips:
            expected = solved.at(place, slip)
            np.testing.assert_allclose(mirrored.at(place, slip), expected, rtol=1e-4, atol=1e-4)
        for name, value in solved.without_friction(place).items():
            assert mirrored.without_friction(place)[name] == pytest.approx(value, rel=1e-6, abs=1e-6), name
    assert all(place.shift >= 0 for place in mirrored.shares)


def test_half_of_the_contacts_of_symmetric_bodies_are_solved(wheel):
    nodes = first_nodes(TableSpecification(shifts=(-1.0, 0.0, 1.0), loads=(LOAD,)))
    jobs = []

    def spread(_, given):
        jobs.extend(given)
        return [columns.Column(dict.fromkeys(CONTACT, 1.0), np.zeros((len(job.slips), 6))) for job in jobs]

    contacts = Contacts(wheel, 8, symmetric=True, options=RunOptions(1), spread=spread)
    contacts.solve(all_contacts(nodes), "")
    slips = 3 * (8 * 7 + 1)
    assert sum(len(job.slips) for job in jobs) == slips + 1 * 57 + (5 * 7 + 1)  # one side; at 0: half of it


# --- tables ---


@pytest.fixture(scope="module")
def table():
    """A table of a wheel on a rail, judged by fewer contacts than others."""
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(refinement, "HELD_OUT", 8)
        return femic.compute_table(
            femic.Pair(WHEEL, RAIL),
            [LOAD],
            [-1.0, 1.0],
            spin=0.0,
            tolerance=0.04,
            elements=8,
            setup=femic.ContactSetup(flanks=False),
            options=femic.Options(workers=1),
        )


def test_contacts_that_no_table_has_seen_are_within_its_tolerance(table):
    """On elements of half the size, at places drawn here."""
    read, pair, errors = femic.read_table(table), femic.Pair(WHEEL, RAIL), []
    random = np.random.default_rng(7)
    for _ in range(3):
        shift = random.uniform(-1, 1)
        setup = femic.ContactSetup(elements=16, shift=shift, flanks=False)
        solver = femic.ContactSolver(pair, LOAD, "Bhat", setup)
        pressed = solver.solve(LOAD)
        contact = read.contact(shift, LOAD)
        assert contact["p_max"] == pytest.approx(pressed.numbers["p_max"], rel=0.02)
        for _ in range(8):
            xi, eta = random.normal(size=2) * FRICTION * contact["creepage_scale"]
            there = solver.solve(approach=pressed.approach, friction=FRICTION, longitudinal=xi, lateral=eta)
            here = read.forces(shift, LOAD, FRICTION, xi, eta)
            errors += [(here[name] - there.numbers[name]) / (FRICTION * LOAD) for name in ("F_x", "F_y")]
    assert np.quantile(np.abs(errors), 0.95) <= 0.04
    assert np.quantile(np.abs(errors), 0.95) > 1e-4


def test_a_table_says_how_accurate_it_is(table):
    assert table.attrs["error"] <= table.attrs["tolerance"] == 0.04
    for name in refinement.DRIVING:
        assert tables.error(table, name) <= 0.04
    assert table.sizes["case"] == 8 * refinement.IN_HELD_OUT
    for variable in table.variables.values():
        assert variable.attrs.keys() >= {"units", "long_name"}


def test_files_give_the_same_as_the_dataset(table, tmp_path):
    femic.write_table(table, tmp_path)
    assert {path.name for path in tmp_path.iterdir()} == {"table.nc", "table.txt", *tables.READERS}
    at = 0.4, LOAD, FRICTION, 1e-3, -5e-4, 0.0
    expected = femic.read_table(table).forces(*at)
    for name, digits in (("table.nc", 1e-12), ("table.txt", 1e-6)):
        found = femic.read_table(tmp_path / name).forces(*at)
        assert found == pytest.approx(expected, rel=digits, abs=1e-3 * digits * LOAD)


def test_other_datasets_and_files_are_refused(table, tmp_path):
    with pytest.raises(WrongInput, match="table: a dataset without m_n: give one of compute_table"):
        femic.read_table(table.drop_vars("m_n"))
    with pytest.raises(WrongInput, match="no such file; `femic table` writes"):
        femic.read_table(tmp_path / "none.nc")
    for name in ("other.txt", "other.nc"):
        (tmp_path / name).write_text("nothing")
        with pytest.raises(WrongInput, match="path = "):
            femic.read_table(tmp_path / name)
    with pytest.raises(WrongInput, match="a table takes flanks and extra_gap only"):
        femic.compute_table(femic.Pair(WHEEL, RAIL), [LOAD], setup=femic.ContactSetup(shift=1.0))
    with pytest.raises(WrongInput, match="rolling_radius"):
        femic.compute_table(femic.Pair(RAIL, RAIL), [LOAD])
    with pytest.raises(WrongInput, match="values must increase"):
        femic.compute_table(femic.Pair(WHEEL, RAIL), [2 * LOAD, LOAD])


def test_what_is_not_reached_is_said_with_its_number(ball, monkeypatch):
    monkeypatch.setattr(refinement, "MOST_ROUNDS", 1)
    monkeypatch.setattr(refinement, "HELD_OUT", 4)
    specification = TableSpecification(shifts=(0.0,), loads=(LOAD,), spin=0.0, tolerance=0.005, elements=8)
    with pytest.raises(
        Failure, match=r"of 95 % of other contacts is within 0\.\d+, not the tolerance of 0\.005"
    ):
        refined_table(ball, specification, RunOptions(1), map)


def test_a_second_run_solves_nothing_again(ball, tmp_path, monkeypatch):
    monkeypatch.setattr(refinement, "HELD_OUT", 4)
    options = RunOptions(1, Store(tmp_path))
    specification = TableSpecification(shifts=(0.0,), loads=(LOAD,), spin=0.0, tolerance=0.2, elements=8)
    first = refined_table(ball, specification, options, map)

    def forbidden(*_):
        raise AssertionError("solved again")

    monkeypatch.setattr(refinement, "solve_column", forbidden)
    again = refined_table(ball, specification, options, map)
    np.testing.assert_array_equal(first.table.values, again.table.values)
    with pytest.raises(AssertionError, match="solved again"):
        refined_table(ball, replace(specification, elements=9), options, map)


def test_nodes_are_inserted_in_the_middle_of_spins_on_both_sides_and_angles_are_doubled():
    nodes = first_nodes(TableSpecification(shifts=(0.0, 1.0, 3.0), loads=(LOAD,)))
    assert refinement.insert(nodes, "shift", [1])["shift"] == (0.0, 1.0, 2.0, 3.0)
    assert refinement.insert(nodes, "spin", [0])["spin"] == (-1.0, -0.5, 0.0, 0.5, 1.0)
    more = refinement.insert(nodes, "turn", [3])["turn"]
    assert set(nodes["turn"]) < set(more)
    assert more == tuple(Fraction(k, 16) for k in range(16))
    assert refinement.insert(nodes, "creepage", [0, 6])["creepage"][:3] == (0.0, 0.06, 0.12)
