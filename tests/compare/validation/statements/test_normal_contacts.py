"""Contacts of a pair under any load, and the measures of statements on them; C is made of A and B-hat."""

from types import SimpleNamespace

import numpy as np
import pytest

from compare.validation.statements import contact_series, finite_elements, normal_contacts
from compare.validation.statements.contact_series import LOAD_SHARE, ContactSeries
from compare.validation.statements.frame import below
from compare.validation.statements.normal_contacts import (
    KURTOSIS_OF_HERTZ,
    OF_HERTZ,
    SOURCE_ANGLES,
    TALL,
    WIDE,
    kurtosis,
    peakedness,
)
from compare.validation.statements.page import STATEMENTS
from compare.validation.statements.runs import Runs
from femic.contact import undeformed
from femic.contact.operators.dense import Asymmetry
from femic.contact.pairs import pair_on_grid
from femic.contact.pairs.ics import ReferenceICs
from femic.reference.run_options import RunOptions
from femic.scenes.load import load_scene
from geometries.errors import Failure
from tests.compare.validation.statements.normal_makers import (
    DS,
    DX,
    N_S,
    N_X,
    approaches,
    contact_of,
    raised,
    spread,
)

ELEMENTS = 8


class Sum:
    """A sum of operators, each times a factor."""

    def __init__(self, *parts):
        self.parts = parts

    def __call__(self, tractions):
        return sum(factor * operator(tractions) for factor, operator in self.parts)

    def coarsened(self):
        return Sum(*((factor, operator.coarsened()) for factor, operator in self.parts))


def made_c(_, on_grid, __):
    """A little beyond B-hat, as seen from A, and 1 % softer with its estimated error."""
    parts = (1.2, on_grid.operator("Bhat")), (-0.2, on_grid.operator("A"))
    softer = Sum(*((1.01 * factor, operator) for factor, operator in parts))
    return ReferenceICs(Sum(*parts), softer, 0.01, Asymmetry(0.0, "nn"), 1.0, 0.0)


class Coarse(Runs):
    def _contact_scene(self, name):
        return load_scene(name, {"contact": {"elements": ELEMENTS}})


@pytest.fixture(scope="module")
def series():
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(contact_series, "normal_reference_ics", made_c)
        made = Coarse(RunOptions(1), 0.01).contact_series(TALL)
        assert made.grids
        yield made


# --- contacts under any load ----------------------------------------------------------------------------


def test_loads_are_found_at_which_the_patch_with_c_turns_by_an_angle(series):
    """A patch goes like the third root of the load or less: angles are right to a third of its accuracy."""
    for degrees in (30.0, 80.0):
        load = series.load_at(degrees)
        assert series.angle(load) == pytest.approx(degrees, rel=LOAD_SHARE)
        assert series.load_at(degrees) == load
    with pytest.raises(Failure, match=r"no load at which the patch of tall with C turns by 140 degrees"):
        series.load_at(140.0)


@pytest.mark.parametrize(
    ("degrees", "factor"), [(5.0, 1.0), (9.9, 1.0), (10.5, 1.1), (11.5, 1.1), (50.0, 1.1)]
)
def test_a_load_has_the_angle_on_one_grid_also_where_the_angle_jumps_to_the_next(
    monkeypatch, degrees, factor
):
    """Angles are a factor of each grid times the third root of the load: 10 at 1 kN, 11 right beyond."""

    def grid(factor, load):
        def solve(loading, _, **__):
            return SimpleNamespace(on_grid=factor, normal=loading.load)

        return SimpleNamespace(load=load, solve=solve)

    made = ContactSeries(SimpleNamespace(name="made"), RunOptions(1), (1.0, 1e6))
    made.grids = [grid(1.0, 1e3), grid(1.1, 1e6)]
    monkeypatch.setattr(contact_series, "angle", lambda factor, load: factor * load ** (1 / 3))
    load = made.load_at(degrees)
    assert load == pytest.approx((degrees / factor) ** 3, rel=LOAD_SHARE)
    assert made.angle(load) == pytest.approx(degrees, rel=LOAD_SHARE)
    assert made.angle(1e3) == pytest.approx(10.0)


def test_each_load_has_the_first_grid_that_is_large_enough(series):
    loads = [shared.load for shared in series.grids]
    assert loads == sorted(loads)
    assert loads[-1] == pytest.approx(series.loads[1])
    for shared in series.grids:
        assert series.grid(shared.load) is shared
        assert series.grid(0.99 * shared.load) is shared
    assert series.grid(2 * loads[-1]) is series.grids[-1]


def test_numbers_are_those_of_the_contact_and_c_is_known_less_well(series):
    """C is 1 % softer with its error: about 0.7 % of p_max, which others do not have."""
    load = series.load_at(30.0)
    with_c, contact = series.numbers(load), series.contact(load)
    assert with_c["load"] == pytest.approx(load)
    assert with_c["p_max"] == np.max(contact.normal.p)
    softer = np.max(contact.perturbed.normal.p) / with_c["p_max"] - 1
    assert softer == pytest.approx(1.01 ** (-2 / 3) - 1, rel=0.05)
    bhat = series.numbers(load, "Bhat")
    assert with_c["estimate_p_max"] - bhat["estimate_p_max"] == pytest.approx(
        abs(softer) * with_c["p_max"], rel=0.2
    )
    assert series.contact(load, "Bhat").perturbed is None


def test_distances_of_the_displaced_body_are_another_contact(series):
    load = series.load_at(80.0)
    linear, exact = series.solved(load), series.solved(load, exact=True)
    assert exact.normal.load == pytest.approx(linear.normal.load)
    assert np.max(exact.normal.p) < 0.99 * np.max(linear.normal.p)


def test_errors_grow_with_the_angle_and_vanish_without_a_turn(series):
    """C is as far beyond B-hat as a fifth of the way from A to B-hat: errors of A are six times as large."""
    low, high = (
        [abs(series.error(series.load_at(angle), ics, "p_max")) for ics in ("A", "Bhat")]
        for angle in (20.0, 80.0)
    )
    assert low[0] < 0.02
    assert high[0] > 5 * low[0]
    assert low[0] / low[1] == pytest.approx(6, rel=0.1)


# --- measures -------------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("shape", "largest", "of_places"),
    [
        (np.ones_like, 1.0, 1.8),
        (lambda t: np.sqrt(1 - t**2), OF_HERTZ, KURTOSIS_OF_HERTZ),
        (lambda t: 1 - t**2, 1.5, 15 / 7),
    ],
)
def test_shapes_of_pressures_have_their_peakedness(shape, largest, of_places):
    places = (np.arange(4000) + 0.5) / 2000 - 1
    p = 7.0 * shape(places)
    assert peakedness(places, p) == pytest.approx(largest, rel=1e-4)
    assert kurtosis(places, p) == pytest.approx(of_places, rel=1e-4)
    assert kurtosis(3 * places + 5, p) == pytest.approx(of_places, rel=1e-4)


def test_profiles_are_those_through_the_middle_of_the_patch():
    """The middle lines are raised along x and s by themselves; places are 1 at the edges of the patch."""
    contact = contact_of(np.outer(raised(N_X - 8, 1.5), raised(N_S - 6, 1.2)))
    for along, n, d, value in (("x", N_X - 8, DX, 1.5), ("s", N_S - 6, DS, 1.2)):
        places, p = normal_contacts.pressure_profile(contact, along)
        inside = p > 0
        assert np.count_nonzero(inside) == n
        assert np.max(np.abs(places[inside])) == pytest.approx(1 - 1 / n)
        assert places[1] - places[0] == pytest.approx(d / (n * d / 2))
        assert peakedness(places, p) == pytest.approx(value)


def test_differences_are_compared_by_pressures_and_by_patch():
    """Pressures of `wide` sum up to twice those of `tall`, whose patch has three times the difference."""
    runs = spread(more=2.0, tall=3.0)()
    for measure, ratio in ((normal_contacts.by_pressures, 2.0), (normal_contacts.by_patch, 3.0)):
        values = list(measure(runs).values())
        assert values == pytest.approx([ratio] * len(values))


def test_what_is_proportional_to_the_load_is_rigid():
    """M_zz is 1e-6 mm/N; a difference of 1.2 times M_zz times load is rigid, but not M_zz."""
    dataset = approaches(bent=0.0, of_mzz=1.2)().fe_contact(SimpleNamespace(loads=(1e3, 5e3, 2e4)))
    assert finite_elements.rigid_compliance(dataset) == pytest.approx(1.2e-6)
    np.testing.assert_allclose(finite_elements.non_rigid_share(dataset), 0.0, atol=1e-15)
    bent = dataset.assign(fe_raw_approach=dataset.fe_raw_approach + np.array([0.0, 0.0, 0.01]))
    assert finite_elements.non_rigid_share(bent)[2] == pytest.approx(0.01)


@pytest.mark.slow
@pytest.mark.parametrize("number", range(26, 33))
def test_statements_have_numbers_panels_and_details(number, series, monkeypatch):
    """With the same contacts for both pairs; differences between pairs vanish then."""
    monkeypatch.setitem(SOURCE_ANGLES, WIDE, SOURCE_ANGLES[TALL])
    monkeypatch.setitem(normal_contacts.SHAPE_LOADS, WIDE, normal_contacts.SHAPE_LOADS[TALL])
    runs, statement = SimpleNamespace(contact_series=lambda _: series), STATEMENTS[number]
    for criterion in statement.criteria:
        values = criterion.measure(runs)
        assert values
        assert np.isfinite(list(values.values())).all(), (criterion.name, values)
    panels = list(statement.panels(runs))
    assert panels
    assert all(np.isfinite(curve.y).all() for panel in panels for curve in panel.curves)
    assert all(isinstance(value, float) for value in statement.details(runs).values())


# --- mutations ------------------------------------------------------------------------------------------

RIGHT_SECTION = undeformed.Undeformed.upper_section
RIGHT_OPERATOR = pair_on_grid.PairOnGrid.operator
RIGHT_DISTANCE = pair_on_grid.PairOnGrid.distance_at


def half_as_curved(self, x, t):
    """The wheel with half of its curvature along x."""
    return RIGHT_SECTION(self, x / np.sqrt(2), t)


def a_stiffer(self, variant):
    operator = RIGHT_OPERATOR(self, variant)
    return Sum((0.9, operator)) if variant == "A" else operator


def exchanged(self, variant):
    """B-hat where B should be, and the other way round."""
    return RIGHT_OPERATOR(self, {"B": "Bhat", "Bhat": "B"}.get(variant, variant))


def no_cosine(self):
    return np.ones(self.grid.n_s)


def doubled(self, approach):
    return 2 * RIGHT_DISTANCE(self, approach)


BETTER = below(1.0, "better", "")(normal_contacts.bhat_over_b([(TALL, "p_max"), (TALL, "b")]))
(ANGLES,) = STATEMENTS[30].criteria
FROM_PRESSURES = STATEMENTS[26].criteria[0]
MUTATIONS = {  # what is wrong, and the criterion of which some case must change
    "A a tenth too stiff": ((pair_on_grid.PairOnGrid, "operator", a_stiffer), FROM_PRESSURES),
    "B and B-hat exchanged": ((pair_on_grid.PairOnGrid, "operator", exchanged), BETTER),
    "no cosine of the approach": ((pair_on_grid.PairOnGrid, "cosine", property(no_cosine)), ANGLES),
    "distance doubled": ((pair_on_grid.PairOnGrid, "distance_at", doubled), ANGLES),
    "half the curvature of the wheel": ((undeformed.Undeformed, "upper_section", half_as_curved), ANGLES),
}


def of_tall(monkeypatch, criterion):
    """Return whether a criterion is met on `tall` alone, by case, with C as it is made here."""
    with monkeypatch.context() as patch:
        patch.setattr(contact_series, "normal_reference_ics", made_c)
        patch.setattr(normal_contacts, "PAIRS", (TALL,))
        patch.setattr(normal_contacts, "SOURCE_ANGLES", {TALL: normal_contacts.SOURCE_ANGLES[TALL]})
        values = criterion.measure(Coarse(RunOptions(1), 0.01))
        return {case: criterion.met(value) for case, value in values.items()}


@pytest.mark.slow
@pytest.mark.parametrize("mutation", MUTATIONS)
def test_wrong_signs_and_factors_of_contact_change_what_is_met(mutation, monkeypatch):
    change, criterion = MUTATIONS[mutation]
    right = of_tall(monkeypatch, criterion)
    monkeypatch.setattr(*change)
    assert of_tall(monkeypatch, criterion) != right
