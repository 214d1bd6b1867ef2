"""Stresses below contacts: numbers of the dataset beside the engines, Hertz's field, the page, messages."""

import tomllib
from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest
import xarray as xr

from compare.pages.stresses import damage_table, stress_table, write_stresses
from femic.cli.main import WRONG_INPUT, exit_code
from femic.contact.loading import Loading
from femic.damage.dang_van import DangVan, equivalent_stress, shear_amplitudes
from femic.damage.fatigue import utilised_friction
from femic.damage.laws import EnergyLaw, depth
from femic.damage.wear import find_sliding
from femic.reference.run_options import RunOptions, Watch
from femic.results import stressed_contact as lattice
from femic.results import stressed_contact as module
from femic.results.damage import OF_DAMAGE, compute_damage
from femic.results.stressed_contact import (
    lattice_below,
    require_stresses,
    solve_contacts,
    with_one_contact,
)
from femic.results.stresses import HALF_SPACE, HALF_SPACE_OF_A, TRUE, compute_stresses, largest_below
from femic.scenes.errors import BadScene
from femic.scenes.load import scene_from_table
from femic.stresses.engine import StressSettings, stress_field
from femic.stresses.field import tresca, von_mises
from femic.stresses.half_space import half_space_field
from geometries.errors import Failure
from geometries.patches import Grid, N
from tests.compare.friction.scenes import RADIUS, scene

ONE = RunOptions(workers=1)
COARSE, FINER = ({"stresses": {"fineness": fineness, "estimated": False}} for fineness in (0.1, 0.25))
CONSTANTS = {"yield_stress": 500.0, "hardness": 3000.0, "speed": 20.0}
ROLLING = {"motion": "rolling", "loads": [5e3], "friction": [0.2, 0.4], "longitudinal": [-0.01, 0.0, 0.01]}
ROUNDING = 1e-9


def with_tables(of, **tables):
    """A scene with other tables."""
    return scene_from_table(tomllib.loads(of.text) | tables, of.name)


def of_lattice(n_x, n_s, n_d):
    """A context in which lattices have these numbers of points."""
    changed = pytest.MonkeyPatch()
    for name, n in (("ALONG_X", n_x), ("ALONG_S", n_s), ("INTO_DEPTH", n_d), ("DEEPER_STILL", 3)):
        changed.setattr(lattice, name, n)
    return changed


@pytest.fixture(scope="module")
def rolling(tmp_path_factory):
    """A wheel that rolls, the lattices below it, the arrays and the page."""
    changed, rolls = of_lattice(5, 4, 3), with_tables(scene(**ROLLING), **COARSE, damage=CONSTANTS)
    contacts = solve_contacts(rolls, ONE)
    lattices = {body: lattice_below(contacts, body) for body in ("upper", "lower")}
    changed.setattr("femic.results.stresses.solve_contacts", lambda *_: contacts)
    dataset = compute_stresses(rolls, ONE)
    changed.setattr("compare.report.parts._on_paper", lambda *_: [])  # pictures for paper take seconds
    page = write_stresses(dataset, tmp_path_factory.mktemp("stresses"))
    changed.undo()
    return SimpleNamespace(
        contacts=contacts, lattices=lattices, dataset=dataset, page=page.read_text(encoding="utf-8")
    )


def test_stresses_are_those_of_the_engines(rolling):
    contacts, dataset = rolling.contacts, rolling.dataset
    for name, below in rolling.lattices.items():
        points, of = below.points, contacts.problem.bodies[name]
        loads = {ics: contacts.on_body(name, ics) for ics in ("A", "Bhat")}
        expected = {
            TRUE: stress_field(of, loads["Bhat"], points, StressSettings(**COARSE["stresses"])).stress,
            HALF_SPACE: half_space_field(of, loads["Bhat"], points).stress,
            HALF_SPACE_OF_A: half_space_field(of, loads["A"], points).stress,
        }
        true = von_mises(expected[TRUE])
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
            for part in below.split(stress):
                cycle = np.concatenate([np.zeros_like(part[:1]), part])
                equivalent = equivalent_stress((cycle + np.swapaxes(cycle, -1, -2)) / 2, DangVan())
                fatigue.append(equivalent.max())
            assert numbers.dang_van == pytest.approx(max(fatigue), rel=ROUNDING)


def test_sections_differ_by_what_the_lattice_shows(rolling):
    dataset = rolling.dataset
    for name in rolling.lattices:
        fields = dataset[f"stress_{name}"].transpose(..., "i", "j").astype(float)
        stresses = {source: von_mises(fields.sel(source=source).values) for source in dataset.source.values}
        at_x, *_ = np.unravel_index(np.argmax(stresses[TRUE]), stresses[TRUE].shape)
        for source, largest in stresses.items():
            away = abs(largest - stresses[TRUE])[at_x].max() / stresses[TRUE].max()
            assert dataset.section_difference.sel(body=name, source=source) == pytest.approx(
                away, abs=1e-6
            )  # fields have 7 digits


def test_wear_numbers_are_those_of_the_contact(rolling):
    for name, solution in rolling.contacts.rolling.items():
        numbers, sliding = rolling.dataset.sel(ics=name), find_sliding(solution.contact, 20.0)
        assert numbers.work == pytest.approx(sliding.total_work)
        assert numbers.utilised_friction == pytest.approx(utilised_friction(solution.contact))
        worn = depth(sliding, EnergyLaw())
        assert numbers.largest_depth_energy == pytest.approx(1e6 * worn.max())  # nm
        assert numbers.depth.sel(law="energy").values == pytest.approx(1e6 * worn)
        p_max, k = solution.contact.p[..., N].max(), 500 / np.sqrt(3)
        assert numbers.surface_index == pytest.approx(float(numbers.utilised_friction) - k / p_max)
        assert numbers.regime_share.sum() == pytest.approx(1.0)


def test_rolls_at_largest_friction_and_prescribed_force(rolling):
    for solution in rolling.contacts.rolling.values():
        assert solution.contact.force[0] == pytest.approx(0.5 * 0.4 * 5e3, rel=1e-3)  # equal_force is 0.5


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
    monkeypatch.setattr(module, "Continuation", lambda *_: along)
    assert np.isnan(module._with_force(pair, None, "").slope)
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


def numbers_with(rolling, **damage):
    """The same of the contact with B-hat."""
    return damage_numbers(rolling.contacts.rolling["Bhat"], **damage)


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
def test_a_law_with_twice_its_coefficients_wears_twice_as_deep(rolling, law, of_depth, keys):
    """And no other number changes."""
    numbers, errors = numbers_with(rolling, **CONSTANTS)
    changed, of_changed = numbers_with(rolling, **CONSTANTS, **{law: keys})
    assert numbers[of_depth] > 0
    assert changed == pytest.approx(numbers | {of_depth: 2 * numbers[of_depth]}, rel=ROUNDING)
    assert of_changed == pytest.approx(errors | {of_depth: 2 * errors[of_depth]}, rel=1e-6)


def test_yield_stress_changes_shakedown_and_surface_fatigue_alone(rolling):
    numbers, errors = numbers_with(rolling, **CONSTANTS)
    changed, of_changed = numbers_with(rolling, **CONSTANTS | {"yield_stress": 1000.0})  # twice
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
    without, _ = numbers_with(rolling, hardness=3e3, speed=20.0)
    assert without == {name: numbers[name] for name in without}
    assert set(numbers) - set(without) == {*expected, "shakedown_limit"}


def test_transitions_of_twin_discs_bound_the_regimes(rolling):
    contact = rolling.contacts.rolling["Bhat"]
    most = float(rolling.dataset.work_density.sel(ics="Bhat").max())
    for limits, regime in (([2 * most, 3 * most], "mild"), ([most / 1e6, 2 * most], "severe")):
        specification = with_tables(scene(**ROLLING), damage={"twin_disc": {"transitions": limits}}).damage
        assert compute_damage(contact, specification).regime_share.sel(regime=regime) == pytest.approx(
            1.0, abs=1e-3
        )


def test_weights_of_dang_van_reach_the_stress(rolling, monkeypatch):
    """Without weight it is the largest shear amplitude; the fields that are stored have 7 digits."""
    dataset = rolling.dataset

    def stored(_, name, *__):
        on_lattice, on_column = (
            dataset[f"{part}_{name}"].sel(source=[TRUE]).values for part in ("stress", "column_stress")
        )
        below = on_column[:, :, on_lattice.shape[3] :]
        stress = np.concatenate([part.reshape(1, -1, 3, 3) for part in (on_lattice, below)], axis=1)
        arrays = {
            "stress": (("source", "point", "i", "j"), stress),
            "estimate": ("point", 0 * stress[0, :, 0, 0]),
        }
        return xr.Dataset(arrays, coords={"source": [TRUE]})

    changed = of_lattice(5, 4, 3)
    monkeypatch.setattr("femic.results.stresses.solve_contacts", lambda *_: rolling.contacts)
    monkeypatch.setattr("femic.results.stresses._solve_or_load", stored)
    without = compute_stresses(with_tables(scene(**ROLLING), damage={"dang_van": {"hydrostatic": 0.0}}), ONE)
    changed.undo()
    for name in rolling.lattices:
        for part in ("", "column_"):
            cycle = dataset[f"{part}stress_{name}"].sel(source=TRUE).values.astype(float)
            cycle = np.concatenate([np.zeros_like(cycle[:1]), cycle])
            cycle = (cycle + np.swapaxes(cycle, -1, -2)) / 2
            trace = np.trace(cycle, axis1=-2, axis2=-1)[..., None, None]
            amplitude = shear_amplitudes(cycle - trace / 3 * np.eye(3)).max(axis=0)
            fatigue = without[f"{part}dang_van_{name}"].sel(source=TRUE)
            np.testing.assert_allclose(fatigue, amplitude, rtol=1e-6)
            with_weight = dataset[f"{part}dang_van_{name}"].sel(source=TRUE)
            assert np.max(np.abs(fatigue - with_weight)) > 0.01 * np.max(amplitude)


@pytest.mark.parametrize(
    ("keys", "friction", "force"),
    [
        ({}, 0.4, 0.5),
        ({"friction": 0.2}, 0.2, 0.5),
        ({"force": 0.0}, 0.4, 0.0),
        ({"friction": 0.2, "force": -0.3}, 0.2, -0.3),
    ],
)
def test_keys_choose_the_contact_of_rolling(keys, friction, force):
    one = with_one_contact(with_tables(scene(**ROLLING), stresses=keys)).contact.friction
    assert (one.coefficients, one.equal_force) == ((friction,), force)


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


def test_ratios_to_nothing_are_none(rolling):
    dataset = rolling.dataset
    nothing = dataset.assign(
        t_gamma=0 * dataset.t_gamma,
        work=0 * dataset.work,
        difference_dang_van=np.nan * dataset.difference_dang_van,
    )
    tables = damage_table(nothing), stress_table(nothing)
    shown = [cell.below for table in tables for row in table.rows for cell in row.filled]
    assert not any("nan" in below or "inf" in below for below in shown)


def test_page_has_sentences_tables_and_figures(rolling):
    page = rolling.page
    for text in (
        "Largest von Mises stress at",
        "half-space, tractions of A",
        "T-gamma",
        "FI_surf",
        "worn by a passage: Archard",
        "depth [mm]",
    ):
        assert text in page


def hertz_scene():
    """A wheel with a straight contour on a rail, both of radius 400 mm: a circular patch."""
    material = {"E": 210e3, "nu": 0.3}
    return scene_from_table(
        {
            "lower": {**material, "contour": {"kind": "arc", "radius": 400.0, "flank_inclination_deg": 10.0}},
            "upper": {**material, "contour": {"kind": "plane"}, "rolling_radius": 400.0},
            "patch": {"a": 0.1, "b": 0.1},
            "contact": {"loads": [2e3, 20e3], "ics": ["A"], "elements": 16},
        },
        "hertz",
    )


def test_large_radii_have_hertz_s_largest_shear_and_its_depth():
    changed = of_lattice(3, 5, 33)
    dataset = compute_stresses(with_tables(hertz_scene(), **FINER), ONE).sel(source=TRUE)
    changed.undo()
    contact_modulus = 210e3 / (2 * (1 - 0.3**2))
    a = (3 * 20e3 * 400 / (4 * contact_modulus)) ** (1 / 3)
    p_0 = 3 * 20e3 / (2 * np.pi * a**2)
    for body in dataset.body.values:
        shear, depth = tresca(dataset[f"stress_{body}"].values) / 2, dataset[f"depth_{body}"].values
        *_, at = np.unravel_index(np.argmax(shear), shear.shape)
        # Johnson (1985), section 3.4, nu = 0.3; 16 elements over the patch, curvature of a / R = 0.6 %
        assert shear.max() == pytest.approx(0.310 * p_0, rel=0.02)
        assert depth[at] == pytest.approx(0.481 * a, abs=np.diff(depth)[at])


def test_refuses_before_any_work(capsys):
    for command, reason in (
        ("tall --friction 0.3", "friction is only of motion = 'rolling'"),
        ("tall --force 0.3", "stresses.force = 0.3: only of contact.motion = 'rolling', not 'none'"),
        ("tall --speed 3", "damage.speed = 3: only of contact.motion = 'rolling', not 'none'"),
        ("rolling --friction -0.3", "contact.friction.0 = -0.3: Input should be greater than 0"),
        ("rolling --force 1", "stresses.force = 1.0: Input should be less than 1"),
        ("rolling --fineness 11", "stresses.fineness = 11.0: Input should be at most 10"),
        ("rolling --yield-stress -3", "damage.yield_stress = -3.0: Input should be at least"),
        ("rolling --hardness 3000", "damage.hardness = 3000: Archard's coefficients depend"),
        ("rolling --speed 0", "damage.speed = 0.0: Input should be at least"),
        ("flat", "give loads"),
    ):
        assert exit_code(["stresses", *command.split()]) == WRONG_INPUT
        assert reason in capsys.readouterr().err
    with pytest.raises(BadScene, match="stresses are those of one contact"):
        require_stresses(scene(motion="transient", loads=[5e3], friction=[0.3]))


@pytest.mark.slow
def test_compression_has_no_passage():
    changed = of_lattice(3, 3, 2)
    keys = {"motion": "compression", "loads": [2e3, 5e3], "friction": [0.3], "ics": ["Bhat"]}
    dataset = compute_stresses(with_tables(scene(**keys), stresses={"fineness": 0.1}), ONE)
    changed.undo()
    assert "ics" not in dataset.dims
    estimates = dataset.sel(source=TRUE).estimate_von_mises
    for name in estimates.body.values:
        here = np.concatenate([dataset[f"{part}estimate_{name}"].values.ravel() for part in ("", "column_")])
        assert np.min(here) < estimates.sel(body=name) < 2 * np.max(here)
    assert not any("dang_van" in str(name) for name in dataset)
    assert dataset.source.values.tolist() == [TRUE, HALF_SPACE]
    assert dataset.attrs["load"] == "5000 N"


def test_lattices_end_before_normals_cross():
    changed = of_lattice(3, 9, 4)
    contacts = SimpleNamespace(
        problem=(problem := scene(**ROLLING).contact_problem),
        on_grid=SimpleNamespace(x=np.linspace(-20, 20, 41)),
        grid=Grid(41, 21, 1.0, 0.8),
        tractions={"A": np.ones((41, 21, 3))},
        offset=lambda _: 0.0,
    )
    below = {name: lattice.lattice_below(contacts, name) for name in problem.bodies}
    changed.undo()
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
    values = of.points.depth - of.points.x
    peak = largest_below(of, "v", of.split(values))
    expected = {"v": 4.0, "x_v": 0.0, "s_v": 1.0, "depth_v": 4.0, "deepest_v": True}
    assert peak == pytest.approx(expected | {"estimate_v": np.nan}, nan_ok=True)
    values = -((of.points.depth - 1.2) ** 2) - (of.points.s - 2) ** 2
    peak = largest_below(of, "v", of.split(values))
    expected = {"v": -0.04, "x_v": 0.0, "s_v": 2.0, "depth_v": 1.0, "deepest_v": False}
    assert peak == pytest.approx(expected | {"estimate_v": np.nan}, nan_ok=True)
