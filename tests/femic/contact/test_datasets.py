"""Views of contacts on larger elements and with changed ICs, and estimates of differences in general."""

import numpy as np
import pytest
import xarray as xr

from approx.pair import Pair, Solid
from femic.contact import datasets
from femic.contact.datasets import (
    FLOOR,
    LARGER,
    MISSED,
    OF_DIFFERENCE,
    OF_UNKNOWN_EDGE,
    WITHOUT_FRICTION,
    estimate_of_difference,
    on_larger_elements,
    variables,
    with_variation,
)
from femic.contact.estimates import EDGE, SAFETY, Measured, Scale
from femic.contact.exact.hertz import PointContact, combined_modulus
from femic.contact.loading import Loading
from femic.contact.motions.none import SolvedContact
from femic.contact.motions.rolling import OF_ROLLING
from femic.contact.pairs.pair_on_grid import PairContact, PairOnGrid
from femic.contact.pairs.quantities import OF_FRICTIONLESS, kinds, numbers
from femic.contact.undeformed import Undeformed
from geometries.contours import arc
from geometries.materials import Material
from geometries.patches import Grid
from geometries.surfaces import LOWER, UPPER, Surface

VARIED = {"a": 10.0, "b": 20.0, "C": 40.0}


def contacts(values=VARIED, larger=VARIED, change=(0.0, 0.0, 0.0)):
    """Contacts with one number q by ICs, and tractions on two by four elements."""
    p = np.arange(24.0).reshape(3, 2, 4)
    table = {
        "q": ("ics", [*values.values()]),
        "larger_q": ("ics", [*larger.values()]),
        "change_q": ("ics", [*change]),
        "p": (("ics", "x", "s"), p),
        "larger_p": (("ics", "larger_x", "larger_s"), p[:, :1, ::2]),
        "change_p": (("ics", "x", "s"), 0 * p),
        "seconds": ("ics", [1.0, 1.0, 1.0]),
    }
    coords = {"ics": [*values], "x": [0.0, 1.0], "s": range(4), "larger_x": [0.5], "larger_s": [0.5, 2.5]}
    return xr.Dataset(table, coords, {"load": 1e3})


def beside_itself(dataset, difference, *norm):
    """The estimate without the share of the difference itself."""
    size = (norm or (abs,))[0](difference(dataset))
    return estimate_of_difference(dataset, difference, *norm) - OF_UNKNOWN_EDGE * size


def apart(dataset, ics="a"):
    return dataset.q.sel(ics=ics) - dataset.q.sel(ics="C")


def test_contacts_on_larger_elements_have_the_same_names_and_their_own_places():
    given = contacts(larger={"a": 1.0, "b": 2.0, "C": np.nan})
    larger = on_larger_elements(given)
    assert {*larger.data_vars} == {"q", "p"}
    np.testing.assert_array_equal(larger.q, [1.0, 2.0, np.nan])
    np.testing.assert_array_equal(larger.p, given.larger_p)
    np.testing.assert_array_equal(larger.s, given.larger_s)
    assert larger.attrs == given.attrs


def test_only_the_named_ics_change():
    given = contacts(change=(1.0, 0.0, 3.0))
    for sign in (1, -1):
        np.testing.assert_allclose(
            with_variation(given, "change_", "C", sign).q, [10.0, 20.0, 40.0 + 3 * sign]
        )
        np.testing.assert_allclose(with_variation(given, "change_", "a", sign).q, [10.0 + sign, 20.0, 40.0])
    assert with_variation(given, "change_", "C", 1).seconds.equals(given.seconds)


@pytest.mark.parametrize("error", [3.0, -3.0, 40.0])
def test_signed_differences_are_bounded_across_zero_and_errors_in_common_are_none(error):
    """q(h) = q + c h of one alone, h = 1 and 2; with 40 the difference changes its sign."""
    given = contacts(VARIED | {"a": 10.0 + error}, VARIED | {"a": 10.0 + 2 * error})
    assert beside_itself(given, apart) == pytest.approx(SAFETY * abs(error))
    alike = contacts(larger={name: value + error for name, value in VARIED.items()})
    assert beside_itself(alike, apart) == pytest.approx(0.0)


def test_grids_that_agree_by_luck_leave_floors_of_both_and_a_share_of_the_difference():
    """Floors add up, whatever the signs of errors; those of other ICs do not count."""
    given = contacts().assign(floor_q=("ics", [0.3, 100.0, 0.5]))
    assert estimate_of_difference(given, apart) == pytest.approx(OF_UNKNOWN_EDGE * 30.0 + 0.3 + 0.5)


def made_contact(edge):
    """A contact whose numbers are 2, with floors of 10 % of them; p_max is exact."""
    of_all = kinds(OF_ROLLING)
    floors = dict.fromkeys({floor for kind in of_all.values() for floor in kind.floors}, 0.1) | {EDGE: edge}
    scales = {kind.scale: Scale(2.0, 2.0) for kind in of_all.values()}
    return Measured(dict.fromkeys(OF_ROLLING, 2.0), scales, floors, ("p_max",))


@pytest.mark.parametrize("shares", [datasets.WITH_FRICTION, WITHOUT_FRICTION])
def test_two_contacts_have_most_of_their_floors_in_common(shares):
    """Of each number that elements can change."""
    contact, of_all = made_contact(0.5), kinds(OF_ROLLING)
    floors = datasets.difference_errors(contact, OF_ROLLING, shares)[FLOOR]
    assert floors.pop("p_max") == 0  # it is exact
    for name, part in floors.items():
        assert 0 <= part / contact.floor(name, of_all[name]) < 0.11, name


def test_elements_miss_less_of_a_difference_the_fewer_of_them_are_at_the_edge():
    """Of several numbers, and of contacts over which a size is found, the largest share counts."""
    rows = datasets.difference_errors_of_all([made_contact(0.5), made_contact(0.1), None], OF_ROLLING)
    shares = [row["F_x"] for row in rows[MISSED]]
    np.testing.assert_array_equal(shares, [0.5 * OF_DIFFERENCE, 0.1 * OF_DIFFERENCE, np.nan])
    given = contacts().assign(missed_q=("ics", [0.01, 0.5, 0.02]), missed_other=("ics", [0.03, 0.0, 0.0]))
    assert estimate_of_difference(given, apart) == pytest.approx(0.5 * 30.0)
    each = estimate_of_difference(given.drop_vars("missed_other"), lambda one: one.q - one.q.sel(ics="C"))
    np.testing.assert_allclose(each.sel(ics=["a", "b"]), [0.01 * 30.0, 0.5 * 20.0])


def test_changes_of_several_ics_may_have_any_signs_and_the_larger_one_of_both_counts():
    """The square of 2 +- 1: 9 - 4 and 4 - 1."""
    assert beside_itself(contacts(change=(1.0, 0.0, 3.0)), apart) == pytest.approx(4.0)
    values = {"a": 2.0, "C": 0.0, "b": 0.0}
    given = contacts(values, values, (1.0, 0.0, 0.0))
    assert beside_itself(given, lambda one: apart(one) ** 2) == pytest.approx(5.0)


@pytest.mark.parametrize("unknown", [{"larger": VARIED | {"a": np.nan}}, {"change": (np.nan, 0.0, 0.0)}])
def test_what_is_not_known_has_no_estimate(unknown):
    given = contacts(**unknown)
    assert np.isnan(estimate_of_difference(given, apart))
    assert beside_itself(given, lambda one: apart(one, "b")) == pytest.approx(0.0)


def test_sizes_of_several_differences_change_by_the_size_of_their_changes():
    """Both differences change their signs, and their largest size stays the same."""
    given = contacts({"a": 5.0, "b": -5.0, "C": 0.0}, {"a": -5.0, "b": 5.0, "C": 0.0})

    def away(one):
        return one.q - one.q.sel(ics="C")

    assert beside_itself(given, away, lambda d: abs(d).max("ics")) == pytest.approx(SAFETY * 10)


@pytest.mark.parametrize("across", [12, 16, 20])
def test_without_friction_differences_are_known_to_a_part_of_themselves(across):
    """Hertz: bodies that are stiffer by 0.05 % differ by as little in p_max and approach."""
    stiffness = {"soft": 200e3, "stiff": 200.1e3}
    radii, load, rolling_radius = (10.0, 11.0), 20.0, 400.0
    rail = Surface(LOWER, arc(radii[0], 1.1, 0.9))
    wheel = Surface(UPPER, arc(radii[1], 1.1, 0.9), rolling_radius)
    curvatures = 1 / rolling_radius, 1 / radii[0] - 1 / radii[1]
    steel = {name: Material(E, 0.3) for name, E in stiffness.items()}
    exact = {
        name: PointContact(*curvatures, combined_modulus(each, each)).at_load(load)
        for name, each in steel.items()
    }
    dx, ds = (2 * size / across for size in (exact["soft"].a, exact["soft"].b))
    grid = Grid(across + 8, across + 8, dx, ds)
    tables = {"": [], LARGER: [], FLOOR: [], MISSED: []}
    for each in steel.values():
        pair = Pair(Solid(each, wheel), Solid(each, rail))
        on_grid = PairOnGrid(pair, Undeformed(wheel, rail, (-9.0, 9.0), 0.0), grid)
        normal = on_grid.solve_in_place(on_grid.operator("A"), Loading(load))
        variations = SolvedContact(Loading(load), "A", PairContact(on_grid, normal)).variations()
        for prefix, table in tables.items():
            table.append(variations[prefix] if prefix else numbers(on_grid, normal))
    given = xr.Dataset(variables(OF_FRICTIONLESS, "ics", tables), {"ics": list(steel)})
    for name in ("p_max", "approach"):
        away = [getattr(exact[ics], name) for ics in steel]

        def difference(contacts, name=name):
            return contacts[name].sel(ics="stiff") - contacts[name].sel(ics="soft")

        found, estimate = float(difference(given)), float(estimate_of_difference(given, difference))
        assert abs(found - (away[1] - away[0])) <= estimate <= 0.15 * abs(found), name
