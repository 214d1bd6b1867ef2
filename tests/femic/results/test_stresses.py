"""Stresses below contacts: numbers of the dataset beside the engines, Hertz's field, messages."""

from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest

from femic.cli.main import WRONG_INPUT, exit_code
from femic.contact.loading import Loading
from femic.damage.dang_van import DangVan, equivalent_stress
from femic.damage.fatigue import utilised_friction
from femic.damage.laws import EnergyLaw, depth
from femic.damage.wear import find_sliding
from femic.reference.run_options import RunOptions, Watch
from femic.results import stressed_contact as lattice
from femic.results.damage import OF_DAMAGE, compute_damage
from femic.results.stressed_contact import require_stresses, with_one_contact
from femic.results.stresses import ACTUAL, HALF_SPACE, HALF_SPACE_OF_A, compute_stresses, largest_below
from femic.scenes.errors import BadScene
from femic.stresses.engine import StressSettings, stress_field
from femic.stresses.field import tresca, von_mises
from femic.stresses.half_space import half_space_field
from geometries.errors import Failure
from geometries.patches import Grid, N
from tests.femic.contact.wheel_on_rail import RADIUS, WHEEL, scene
from tests.femic.results.solved_stresses import (
    COARSE,
    CONSTANTS,
    FINER,
    ONE,
    ROLLING,
    lattices,
    rolling_stresses,
    with_tables,
)

ROUNDING = 1e-9


@pytest.fixture
def rolling():
    return rolling_stresses()


@pytest.fixture
def with_bhat(rolling):
    """The contact with B-hat."""
    return rolling.contacts.rolling["Bhat"]


def test_stresses_are_those_of_the_engines(rolling):
    """And Dang Van's stress that of passages through them, by the weight of the scene."""
    contacts, dataset = rolling.contacts, rolling.dataset
    for name, below in rolling.lattices.items():
        points, of = below.points, contacts.problem.bodies[name]
        loads = {ics: contacts.on_body(name, ics) for ics in ("A", "Bhat")}
        expected = {
            ACTUAL: stress_field(of, loads["Bhat"], points, StressSettings(**COARSE["stresses"])).stress,
            HALF_SPACE: half_space_field(of, loads["Bhat"], points).stress,
            HALF_SPACE_OF_A: half_space_field(of, loads["A"], points).stress,
        }
        true = von_mises(expected[ACTUAL])
        for source, stress in expected.items():
            numbers, largest = dataset.sel(body=name, source=source), von_mises(stress)
            assert numbers.von_mises == pytest.approx(largest.max(), rel=ROUNDING)
            assert numbers.tresca == pytest.approx(tresca(stress).max(), rel=ROUNDING)
            assert numbers.principal == pytest.approx(np.linalg.eigvalsh(stress).max(), rel=ROUNDING)
            assert numbers.difference_von_mises == pytest.approx(largest.max() / true.max() - 1, abs=1e-9)
            at = np.argmax(largest)
            places = [float(numbers[f"{place}_von_mises"]) for place in ("x", "s", "depth")]
            assert places == [points.x[at], points.s[at] - below.offset, points.depth[at]]
            fatigue = []
            for prefix, part in zip(("", "column_"), below.split(stress), strict=True):
                cycle = np.concatenate([np.zeros_like(part[:1]), part])
                equivalent = equivalent_stress((cycle + np.swapaxes(cycle, -1, -2)) / 2, DangVan(0.2))
                stored = dataset[f"{prefix}dang_van_{name}"].sel(source=source)
                np.testing.assert_allclose(stored, equivalent, atol=1e-6 * equivalent.max())
                fatigue.append(equivalent.max())
            assert numbers.dang_van == pytest.approx(max(fatigue), rel=ROUNDING)


@pytest.mark.parametrize(("body", "radius", "outward"), [("lower", RADIUS, -1), ("upper", WHEEL, 1)])
def test_outlines_are_the_arcs_and_depths_go_along_their_radii(rolling, body, radius, outward):
    """Both have their centres below the origin, where they touch; the outline has the s of the lattice."""
    dataset, centre = rolling.dataset, np.array([[0.0], [-radius]])
    outline, inward = (dataset[f"{name}_{body}"].values for name in ("outline", "inward"))
    s = dataset[f"outline_s_{body}"].values
    assert set(dataset[f"s_{body}"].values) <= set(s)
    assert s[0] < dataset[f"s_{body}"][0] < dataset[f"s_{body}"][-1] < s[-1]
    angle = s / radius
    np.testing.assert_allclose(outline, centre + radius * np.array([np.sin(angle), np.cos(angle)]), atol=1e-9)
    np.testing.assert_allclose(inward, outward * (outline - centre) / radius, atol=1e-9)
    assert np.min(np.hypot(*outline)) < 1e-9


def test_sections_differ_by_what_the_lattice_shows(rolling):
    dataset = rolling.dataset
    for name in rolling.lattices:
        fields = dataset[f"stress_{name}"].transpose(..., "i", "j").astype(float)
        stresses = {source: von_mises(fields.sel(source=source).values) for source in dataset.source.values}
        at_x, *_ = np.unravel_index(np.argmax(stresses[ACTUAL]), stresses[ACTUAL].shape)
        for source, largest in stresses.items():
            away = abs(largest - stresses[ACTUAL])[at_x].max() / stresses[ACTUAL].max()
            # fields have 7 digits
            assert dataset.section_difference.sel(body=name, source=source) == pytest.approx(away, abs=1e-6)


def test_wear_numbers_are_those_of_the_contact(rolling):
    """It rolls at the largest friction, with the force at which scenes compare, half of the limit."""
    for name, solution in rolling.contacts.rolling.items():
        assert solution.contact.force[0] == pytest.approx(0.5 * 0.4 * 5e3, rel=1e-3)
        numbers, sliding = rolling.dataset.sel(ics=name), find_sliding(solution.contact, 20.0)
        assert numbers.work == pytest.approx(sliding.total_work)
        assert numbers.utilised_friction == pytest.approx(utilised_friction(solution.contact))
        worn = depth(sliding, EnergyLaw())
        assert numbers.largest_depth_energy == pytest.approx(1e6 * worn.max())  # nm
        assert numbers.depth.sel(law="energy").values == pytest.approx(1e6 * worn)
        p_max, k = solution.contact.p[..., N].max(), 500 / np.sqrt(3)
        assert numbers.surface_index == pytest.approx(float(numbers.utilised_friction) - k / p_max)
        assert numbers.regime_share.sum() == pytest.approx(1.0)


def test_without_a_contact_beside_it_the_slope_is_not_known(monkeypatch):
    said = []

    def with_force(force, _):
        if force == 0.5:
            return
        raise Failure("no contact")

    pair = SimpleNamespace(
        options=RunOptions(watch=Watch(on_stage=said.append)),
        specification=SimpleNamespace(equal_force=0.5),
        loads=[1.0],
        rolling=lambda _: None,
    )
    along = SimpleNamespace(largest=1.0, with_force=with_force, first=lambda: None, problem=None)
    monkeypatch.setattr(lattice, "Continuation", lambda *_: along)
    assert np.isnan(lattice._with_force(pair, None, "").slope)
    assert said == ["  no slope of the creep-force curve: no contact"]


def test_estimates_contain_what_the_linearised_distance_does(rolling):
    """To the pressure as without friction: tangential tractions move it little."""
    contacts, solved = rolling.contacts, rolling.contacts.rolling["Bhat"]
    linear, exact = (
        contacts.on_grid.solve(contacts.on_grid.operator("Bhat"), Loading(solved.load), exact=exact)
        for exact in (False, True)
    )
    moved = abs(exact.normal.p.max() - linear.normal.p.max())
    (_, known), (_, without) = (
        damage_numbers(one, **CONSTANTS) for one in (solved, replace(solved, changed=()))
    )
    assert known["p_max"] - without["p_max"] == pytest.approx(moved, rel=0.1)
    forces = [one.contact.force[0] for one in (solved, solved.changed[0])]
    assert forces[0] == pytest.approx(forces[1], rel=1e-5)  # it is prescribed
    assert all(known[name] > without[name] for name in known)


def damage_numbers(solution, **damage):
    """The numbers of a contact, and their errors, with a table [damage]."""
    found = compute_damage(solution, with_tables(scene(**ROLLING), damage=damage).damage)
    names = [name for name in OF_DAMAGE if name in found]
    return ({name: float(found[prefix + name]) for name in names} for prefix in ("", "estimate_"))


@pytest.mark.parametrize(
    ("law", "of_depth", "keys"),
    [
        ("energy", "largest_depth_energy", {"mild": 1.4, "severe": 4.2}),
        ("energy", "largest_depth_energy", {"density": 7850 / 2}),
        ("twin_disc", "largest_depth_twin_disc", {"density": 7850 / 2}),
        (
            "archard",
            "largest_depth_Archard",
            {"slow": 10e-4, "middle": 70e-4, "fast": 10e-4, "seizure": 700e-4},
        ),
    ],
)
def test_a_law_with_twice_its_coefficients_wears_twice_as_deep(with_bhat, law, of_depth, keys):
    """And no other number changes."""
    numbers, errors = damage_numbers(with_bhat, **CONSTANTS)
    changed, of_changed = damage_numbers(with_bhat, **CONSTANTS, **{law: keys})
    assert numbers[of_depth] > 0
    assert changed == pytest.approx(numbers | {of_depth: 2 * numbers[of_depth]}, rel=ROUNDING)
    assert of_changed == pytest.approx(errors | {of_depth: 2 * errors[of_depth]}, rel=1e-6)


def test_yield_stress_changes_shakedown_and_surface_fatigue_alone(with_bhat):
    numbers, errors = damage_numbers(with_bhat, **CONSTANTS)
    changed, of_changed = damage_numbers(with_bhat, **CONSTANTS | {"yield_stress": 1000.0})  # twice
    of_friction = errors["utilised_friction"]
    of_expected = {
        "pressure_ratio": errors["pressure_ratio"] / 2,
        "load_factor": 2 * errors["load_factor"],
        "surface_index": of_friction + 2 * (errors["surface_index"] - of_friction),
    }
    assert of_changed == pytest.approx(errors | of_expected, rel=ROUNDING)
    k = 500 / np.sqrt(3)
    expected = {
        "pressure_ratio": numbers["pressure_ratio"] / 2,
        "load_factor": 2 * numbers["load_factor"],
        "surface_index": numbers["surface_index"] - k / numbers["p_max"],
    }
    assert changed == pytest.approx(numbers | expected, rel=ROUNDING)
    without, _ = damage_numbers(with_bhat, hardness=3e3, speed=20.0)
    assert without == {name: numbers[name] for name in without}
    assert set(numbers) - set(without) == {*expected, "shakedown_limit"}


def test_transitions_of_twin_discs_bound_the_regimes(rolling, with_bhat):
    most = float(rolling.dataset.work_density.sel(ics="Bhat").max())
    for limits, regime in (([2 * most, 3 * most], "mild"), ([most / 1e6, 2 * most], "severe")):
        of = with_tables(scene(**ROLLING), damage={"twin_disc": {"transitions": limits}})
        share = compute_damage(with_bhat, of.damage).regime_share.sel(regime=regime)
        assert share == pytest.approx(1.0, abs=1e-3)


@pytest.mark.parametrize("friction", [{}, {"friction": 0.2}])
@pytest.mark.parametrize("force", [{}, {"force": 0.0}, {"force": -0.3}])
def test_keys_choose_the_contact_of_rolling(friction, force):
    one = with_one_contact(with_tables(scene(**ROLLING), stresses=friction | force)).contact.friction
    assert one.coefficients == (friction.get("friction", 0.4),)
    assert one.equal_force == force.get("force", 0.5)


def test_without_friction_the_largest_load_or_else_approach_is_solved():
    for keys, loads, approaches in (
        ({"loads": [2e3, 5e3, 3e3], "approaches": []}, (5e3,), ()),
        ({"approaches": [0.01, 0.03, 0.02]}, (), (0.03,)),
    ):
        one = with_one_contact(scene(**keys)).contact
        assert (one.loads, one.approaches) == (loads, approaches)


def solved_by_command(monkeypatch, *arguments):
    """The scene that a command solves."""
    solved = []

    def note(scene, *_, **__):
        solved.append(scene)
        raise BadScene("only noted")

    monkeypatch.setattr("femic.results.stresses.compute_stresses", note)
    assert exit_code(["stresses", *arguments]) == WRONG_INPUT
    return solved[0]


def test_options_take_the_place_of_keys(tmp_path, monkeypatch):
    keys = {
        "stresses": {"friction": 0.2, "force": 0.1, "fineness": 0.5, "estimated": False},
        "damage": CONSTANTS | {"energy": {"mild": 1.4}},
    }
    of_keys, path = with_tables(scene(**ROLLING), **keys), tmp_path / "mine.toml"
    path.write_text(of_keys.text, encoding="utf-8")
    place = [str(path), "--out", str(tmp_path / "out")]
    same = solved_by_command(monkeypatch, *place)
    assert (same.stresses, same.damage) == (of_keys.stresses, of_keys.damage)
    options = "--friction 0.3 --force -0.2 --fineness 2 --yield-stress 700 --speed 10 --ics A"
    other = solved_by_command(monkeypatch, *place, *options.split())
    assert other.stresses == replace(of_keys.stresses, friction=0.3, force=-0.2, fineness=2.0)
    assert other.damage == replace(of_keys.damage, yield_stress=700.0, speed=10.0)
    assert with_one_contact(other).contact.friction.coefficients == (0.3,)
    assert other.contact.ics == ("A",)


def test_large_radii_have_hertz_s_largest_shear_and_its_depth():
    """A wheel with a straight contour on a rail, both of radius 400 mm: a circular patch."""
    rail = {"contour": {"kind": "arc", "radius": 400.0, "flank_inclination_deg": 10.0}}
    keys = {"loads": [2e3, 20e3], "ics": ["A"], "elements": 14}
    of = scene(lower=rail, upper={"contour": {"kind": "plane"}}, **keys)
    with lattices(3, 3, 33):
        dataset = compute_stresses(with_tables(of, **FINER), ONE).sel(source=ACTUAL)
    contact_modulus = 210e3 / (2 * (1 - 0.3**2))
    a = (3 * 20e3 * 400 / (4 * contact_modulus)) ** (1 / 3)
    p_0 = 3 * 20e3 / (2 * np.pi * a**2)
    for body in dataset.body.values:
        shear, depth = tresca(dataset[f"stress_{body}"].values) / 2, dataset[f"depth_{body}"].values
        *_, at = np.unravel_index(np.argmax(shear), shear.shape)
        # Johnson (1985), section 3.4, nu = 0.3; 14 elements over the patch, curvature of a / R = 0.6 %
        assert shear.max() == pytest.approx(0.310 * p_0, rel=0.02)
        assert depth[at] == pytest.approx(0.481 * a, abs=np.diff(depth)[at])


@pytest.mark.parametrize(
    ("command", "reason"),
    [
        ("tall --speed 3", "damage.speed = 3: only of contact.motion = 'rolling', not 'none'"),
        ("rolling --friction -0.3", "contact.friction.0 = -0.3: Input should be greater than 0"),
        ("rolling --fineness 11", "stresses.fineness = 11.0: Input should be at most 10"),
        ("flat", "give loads"),
    ],
)
def test_refuses_before_any_work(command, reason, capsys):
    assert exit_code(["stresses", *command.split()]) == WRONG_INPUT
    assert reason in capsys.readouterr().err


def test_transient_rolling_has_no_one_contact():
    with pytest.raises(BadScene, match="stresses are those of one contact"):
        require_stresses(scene(motion="transient", loads=[5e3], friction=[0.3]))


@pytest.mark.slow
def test_compression_has_no_passage():
    keys = {"motion": "compression", "loads": [2e3, 5e3], "friction": [0.3], "ics": ["Bhat"]}
    with lattices(3, 3, 2):
        dataset = compute_stresses(with_tables(scene(**keys), stresses={"fineness": 0.1}), ONE)
    assert "ics" not in dataset.dims
    estimates = dataset.sel(source=ACTUAL).estimate_von_mises
    for name in estimates.body.values:
        here = np.concatenate([dataset[f"{part}estimate_{name}"].values.ravel() for part in ("", "column_")])
        assert np.min(here) < estimates.sel(body=name) < 2 * np.max(here)
    assert not any("dang_van" in str(name) for name in dataset)
    assert dataset.source.values.tolist() == [ACTUAL, HALF_SPACE]
    assert dataset.attrs["load"] == "5000 N"


def test_lattices_end_before_normals_cross():
    contacts = SimpleNamespace(
        problem=(problem := scene(**ROLLING).contact_problem),
        on_grid=SimpleNamespace(x=np.linspace(-20, 20, 41)),
        grid=Grid(41, 21, 1.0, 0.8),
        tractions={"A": np.ones((41, 21, 3))},
        offset=lambda _: 0.0,
    )
    with lattices(3, 9, 4):
        below = {name: lattice.lattice_below(contacts, name) for name in problem.bodies}
    wanted = 2 * 21 * 0.8 / 2
    assert 0.6 * RADIUS < below["lower"].depth[-1] <= (1 - lattice.LEAST_SPREAD) * RADIUS  # in steps of 10 %
    assert below["lower"].column[-1] == pytest.approx(wanted)  # beyond the centre of curvature
    assert np.all(np.diff(below["lower"].column) > 0)
    assert below["upper"].depth[-1] == pytest.approx(wanted)  # normals spread apart in the wheel
    assert len(below["upper"].deeper) == 0


def test_points_return_to_the_lattice_and_its_column():
    of = lattice.Lattice(np.arange(2.0), np.arange(3.0), np.arange(4.0), np.array([5.0, 7.0]), 1, 10.0)
    points = of.points
    on_lattice, on_column = of.split(np.stack([points.x, points.s, points.depth], axis=-1))
    assert on_lattice.shape == (2, 3, 4, 3)
    assert on_lattice[1, 2, 3].tolist() == [1.0, 12.0, 3.0]
    np.testing.assert_array_equal(on_column[1, :, 1], 11.0)
    np.testing.assert_array_equal(on_column[1, :, 2], [0, 1, 2, 3, 5, 7])


def test_the_deepest_largest_stress_is_called_so():
    """Values grow into depth: on the column beyond the lattice; then they have a top inside."""
    of = lattice.Lattice(np.arange(3.0), np.arange(3.0), np.arange(3.0), np.array([3.0, 4.0]), 1, 0.0)
    x, s, depth = of.points.x, of.points.s, of.points.depth
    for values, v, at, deepest in (
        (depth - x, 4.0, (0.0, 1.0, 4.0), True),
        (-((depth - 1.2) ** 2) - (s - 2) ** 2, -0.04, (0.0, 2.0, 1.0), False),
    ):
        expected = {"v": v, "x_v": at[0], "s_v": at[1], "depth_v": at[2], "deepest_v": deepest}
        peak = largest_below(of, "v", of.split(values))
        assert peak == pytest.approx(expected | {"estimate_v": np.nan}, nan_ok=True)
