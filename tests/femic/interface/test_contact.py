"""Contact in Python: of the scene route, limits, ICs of one's own, every motion, wrong input."""

from dataclasses import replace

import numpy as np
import pytest
import xarray as xr

import femic
from femic.contact.operators.dense import Asymmetry
from femic.contact.pairs.ics import ReferenceICs, normal_operator
from femic.results.contact import compute_contact
from femic.results.friction import compute_with_friction
from tests.femic.scenes.changes import arc

STEEL = femic.Material(E=210e3, nu=0.3)
PAIR = femic.Pair(
    femic.Body(femic.arc(10.6, 60.0), STEEL, rolling_radius=500.0), femic.Body(femic.arc(10.0, 60.0), STEEL)
)
SETUP = femic.ContactSetup(elements=8)
OPTIONS, DEFAULT = femic.Options(tolerance=0.3, workers=1), femic.Options()
LOAD, FRICTION = 10e3, 0.3
GRID = femic.Grid(n_x=16, n_s=20, dx=1.1, ds=0.55)
ROLLING = femic.Rolling(LOAD, FRICTION, longitudinal=(0.0, 0.004))
MOTIONS = {  # and the keys of the table [contact]
    "none": (femic.Frictionless([LOAD]), {}),
    "rolling": (ROLLING, {"friction": [FRICTION], "longitudinal": [0.0, 0.004]}),
    "transient": (
        femic.TransientRolling(LOAD, FRICTION, creepage=0.004, distance=9.0),
        {"friction": [FRICTION], "creepage": 0.004, "distance": 9.0},
    ),
    "compression": (
        femic.Compression([LOAD / 2, LOAD], FRICTION),
        {"friction": [FRICTION], "loads": [LOAD / 2, LOAD]},
    ),
}


def solve(motion, ics, setup=SETUP, options=DEFAULT, pair=PAIR):
    """A contact of the pair in one of the motions."""
    return femic.solve_contact(pair, MOTIONS[motion][0], ics, setup, options)


def scene(**contact):
    """The scene of the pair, from a file's keys."""
    lower, upper = ({"nu": 0.3} | arc(60.0, radius) for radius in (10.0, 10.6))
    keys = {"lower": lower, "upper": upper | {"rolling_radius": 500.0}, "engine": {"tolerance": 0.3}}
    return femic.load_scene("flat", keys | {"contact": {"elements": 8, "loads": [LOAD], **contact}})


def motions(*quick):
    """All motions; those that are not named are slow."""
    return [name if name in quick else pytest.param(name, marks=pytest.mark.slow) for name in MOTIONS]


def same(ours, theirs):
    """Whether all numbers agree; seconds do not."""
    for name in set(theirs.data_vars) - {"seconds"}:
        xr.testing.assert_allclose(ours[name], theirs[name], rtol=1e-12)


@pytest.fixture
def asked(monkeypatch):
    """The scenes that are solved, instead of their solution."""
    scenes = []
    for name in ("compute_contact", "compute_with_friction"):
        monkeypatch.setattr(f"femic.interface.contact.{name}", lambda *given: scenes.append(given[0]))
    return scenes


@pytest.mark.parametrize("motion", MOTIONS)
def test_a_pair_is_the_problem_of_its_scene(motion, asked):
    solve(motion, ["A", "Bhat"])
    ours, theirs = asked[0], scene(motion=motion, ics=["A", "Bhat"], **MOTIONS[motion][1])
    assert ours.contact == theirs.contact
    assert ours.settings.tolerance == 0.01
    for name in ("lower", "upper"):
        body, same_body = ours.bodies[name], theirs.bodies[name]
        assert (body.material, body.rolling_radius) == (same_body.material, same_body.rolling_radius)


def test_the_lateral_force_and_the_exact_distance_are_those_of_a_scene(asked):
    motion = femic.Frictionless([LOAD], lateral_force=500.0)
    femic.solve_contact(PAIR, motion, ["A"], replace(SETUP, gap="exact"))
    assert asked[0].contact == scene(ics=["A"], lateral_force=500.0, gap="exact").contact


@pytest.fixture(scope="module")
def pressed():
    """Without friction, by A and by B-hat."""
    return solve("none", ["A", "Bhat"])


def test_contact_of_a_pair_equals_that_of_its_scene(pressed):
    same(pressed, compute_contact(scene(ics=["A", "Bhat"])))
    assert pressed.p_max.attrs["units"] == "MPa"
    np.testing.assert_allclose(pressed["load"], LOAD, rtol=1e-6)
    labels = {
        text for axes in femic.plot_contact(pressed).axes for text in axes.get_legend_handles_labels()[1]
    }
    assert any("B̂" in label for label in labels)


@pytest.mark.parametrize("motion", motions("none", "compression"))
def test_each_variable_has_a_unit_and_says_what_it_alone_is(motion):
    variables = solve(motion, ["A"]).variables
    names = [one.attrs["long_name"] for one in variables.values() if one.dtype.kind != "U"]
    assert len({*names}) == len(names)
    assert all("units" in one.attrs for one in variables.values() if one.dtype.kind in "if")
    assert variables["estimate_p_max"].attrs["long_name"] == "largest pressure: estimated error"


def test_friction_by_angle_is_that_of_a_scene():
    """At a tenth of the coefficient everywhere, the contact bears a tenth of friction times pressure."""
    law = [(0.0, 0.1), (40.0, 0.1)]
    ours = femic.solve_contact(PAIR, femic.Compression([LOAD], FRICTION, law), ["A"], SETUP)
    keys = {"motion": "compression", "friction": [FRICTION], "friction_by_angle": law}
    same(ours, compute_with_friction(scene(ics=["A"], **keys)))
    p = ours.p.squeeze()
    bound = 0.1 * FRICTION * p.sel(direction="n")
    borne = np.hypot(p.sel(direction="x"), p.sel(direction="s"))
    assert float((borne / bound.where(bound > 0)).max()) == pytest.approx(1.0, abs=1e-5)
    assert femic.Rolling(LOAD, FRICTION, friction_by_angle=law).keys["friction_by_angle"] == law


@pytest.fixture(scope="module")
def c():
    """B-hat on the grid under the name of C, with an estimate: C takes half a minute."""
    b_hat = femic.compute_matrix(PAIR, GRID, "Bhat").ic.values
    return femic.label_matrix(b_hat, GRID, "C", 0.02 * np.abs(b_hat))


def test_a_matrix_named_c_gives_the_contact_of_that_c(c, monkeypatch):
    """With the same ICs in the place of those that the pair's models have."""
    nn, estimate = (part.sel(i="n", j="n").values for part in (c.ic, c.estimate))
    own = ReferenceICs(
        normal_operator(nn), normal_operator(nn + estimate), 0.02, Asymmetry(0.0, "nn"), 1.0, 0.0
    )
    monkeypatch.setattr("femic.contact.pairs.ics.normal_reference_ics", lambda *_: own)
    setup = replace(SETUP, grid=GRID)
    ours, theirs = (solve("none", [ics], setup, OPTIONS) for ics in (c, "C"))
    for name in ("p_max", "approach", "a", "b", "estimate_p_max", "estimate_approach"):
        np.testing.assert_allclose(ours[name], theirs[name], rtol=1e-9)


@pytest.mark.slow
def test_c_given_as_a_matrix_gives_the_contact_of_c():
    """Both differ in their models alone: those of nn have fewer loads."""
    setup, c = replace(SETUP, grid=GRID), femic.compute_matrix(PAIR, GRID, "C", OPTIONS)
    ours, theirs = (solve("none", [ics], setup, OPTIONS) for ics in (c, "C"))
    for name in ("p_max", "approach", "a", "b"):
        np.testing.assert_allclose(ours[name], theirs[name], rtol=1e-6)
        np.testing.assert_allclose(ours[f"estimate_{name}"], theirs[f"estimate_{name}"], rtol=0.01)


@pytest.mark.parametrize("motion", motions("none", "transient"))
def test_an_approximation_given_as_a_matrix_is_the_approximation(motion):
    """Of the wheel as a prismatic body: fast operators take it so."""
    prismatic = replace(PAIR, upper=replace(PAIR.upper, rolling_radius=np.inf))
    matrix = femic.compute_matrix(prismatic, GRID, "Bhat").assign_attrs(ics="mine")
    both = solve(motion, ["Bhat", matrix])
    for name in ("p_max", "approach", "a"):
        mine, theirs = both[name].sel(ics="mine"), both[name].sel(ics="Bhat")
        np.testing.assert_allclose(mine, theirs, rtol=1e-6)  # to the solvers' tolerance


@pytest.mark.parametrize("motion", [pytest.param("rolling", marks=pytest.mark.slow), "compression"])
def test_errors_of_given_ics_reach_the_estimates(motion):
    b_hat = femic.compute_matrix(PAIR, GRID, "Bhat")
    exact, unsure = (
        femic.label_matrix(b_hat.ic.values, GRID, name, estimate)
        for name, estimate in (("exact", None), ("unsure", 0.05 * np.abs(b_hat.ic.values)))
    )
    both = solve(motion, [exact, unsure])
    np.testing.assert_array_equal(both.approach.sel(ics="exact"), both.approach.sel(ics="unsure"))
    assert np.all(both.estimate_approach.sel(ics="unsure") > both.estimate_approach.sel(ics="exact"))


@pytest.mark.parametrize("motion", motions("none", "transient", "compression"))
def test_c_that_is_given_is_not_computed_again(motion, c, monkeypatch):
    monkeypatch.setattr("femic.contact.pairs.ics.matrices", None)
    contact = solve(motion, [c], options=femic.Options(engine="solid"))
    assert list(contact.ics.values) == ["C"]
    assert np.all(contact.p_max > 0)


def test_stiffer_ics_give_less_approach():
    """ICs and approach are proportional where pressures are given by the load: half the ICs, stiffer."""
    b_hat = femic.compute_matrix(PAIR, GRID, "Bhat")
    half = femic.label_matrix(b_hat.ic.values / 2, GRID, "half")
    both = solve("none", [b_hat, half])
    soft, stiff = (both.sel(ics=name, case=LOAD) for name in ("Bhat", "half"))
    assert float(stiff.approach) < float(soft.approach)
    assert float(stiff.p_max) > float(soft.p_max)


def test_extra_gap_of_arrays_reduces_the_pressure_there():
    gap = np.array([[-0.5, 0.0], [0.0, 2e-3], [0.5, 0.0]])
    smooth, pitted = (
        solve("none", ["A"], replace(SETUP, grid=GRID, extra_gap=extra)).p for extra in (None, gap)
    )
    in_pit = abs(smooth.s) < GRID.ds
    assert pitted.where(in_pit).max() < 0.95 * smooth.where(in_pit).max()


def test_wrong_input_is_refused_with_its_name():
    still, twice = MOTIONS["none"][0], ["Bhat", femic.compute_matrix(PAIR, GRID, "Bhat")]
    grids = [femic.compute_matrix(PAIR, replace(GRID, n_x=n), ics) for n, ics in ((16, "A"), (8, "Bhat"))]
    for arguments, message in (
        ((PAIR, femic.Frictionless(), ["A"]), "give loads"),
        ((PAIR, ROLLING, twice), "two have the same name"),
        ((PAIR, ROLLING, ["A"], replace(SETUP, gap="exact")), "gap is only of motion = 'none'"),
        ((femic.Pair(PAIR.lower, PAIR.lower), still, ["A"]), "two prismatic bodies"),
        ((PAIR, still, grids), "different grids"),
    ):
        with pytest.raises(femic.WrongInput, match=message):
            femic.solve_contact(*arguments)
