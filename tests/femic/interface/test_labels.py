"""Labels decide: datasets in any order give the same contacts, files, errors and figures, or are refused."""

from dataclasses import replace

import numpy as np
import pytest
import xarray as xr

import femic
from compare.pages.contact_figures import surfaces
from femic.interface.labels import contacts_by_label
from femic.interface.matrices import ordered
from tests.femic.reference.stand_ins import b_hat_as_c

STEEL = femic.Material(E=210e3, nu=0.3)
SOFT = femic.Material(E=70e3, nu=0.2)  # so that xn is not zero
PAIR = femic.Pair(
    femic.Body(femic.arc(10.6, 60.0), SOFT, rolling_radius=500.0), femic.Body(femic.arc(10.0, 60.0), STEEL)
)
GRID = femic.Grid(n_x=14, n_s=15, dx=0.9, ds=0.45, s=0.4)
SETUP = femic.ContactSetup(elements=8, shift=0.01)
ORDERS = {
    "directions": lambda labelled: labelled.sel(i=["n", "s", "x"], j=["s", "x", "n"]),
    "dimensions": lambda labelled: labelled.transpose("j", ..., "i"),
    "i and j exchanged": lambda labelled: labelled.transpose(..., "j", "i"),
    "strips reversed": lambda labelled: labelled.isel(observed=slice(None, None, -1)),
    "loads reversed": lambda labelled: labelled.isel(loaded=slice(None, None, -1), lag=slice(None, None, -1)),
    "strips and loads exchanged": lambda labelled: labelled.transpose("lag", "loaded", "observed", ...),
    "shuffled": lambda labelled: labelled.isel(
        observed=np.random.default_rng(1).permutation(GRID.n_s),
        lag=np.random.default_rng(2).permutation(GRID.n_x),
    ),
}


@pytest.fixture(scope="module")
def matrix():
    """B-hat with an estimate, which has no symmetry."""
    b_hat = femic.compute_matrix(PAIR, GRID, "Bhat").ic.values
    estimate = np.abs(b_hat) * np.linspace(0.01, 0.03, GRID.n_s)[None, :, None, None, None]
    return femic.label_matrix(b_hat, GRID, "mine", estimate)


@pytest.fixture(scope="module")
def pressed(matrix):
    """A contact with friction, which all components of the matrix shape."""
    return compressed(matrix)


def compressed(matrix):
    return femic.solve_contact(PAIR, femic.Compression([1.5e3], 0.3), [matrix], SETUP)


@pytest.mark.parametrize("order", ORDERS.values(), ids=ORDERS)
def test_a_matrix_is_read_and_labelled_again_by_its_labels(order, matrix):
    xr.testing.assert_identical(ordered("ics", order(matrix)), matrix)
    again = femic.label_matrix(order(matrix).ic, GRID, "mine", order(matrix).estimate)
    xr.testing.assert_identical(again, matrix)


@pytest.mark.parametrize("name", ["directions", "i and j exchanged", "strips reversed", "loads reversed"])
def test_contacts_and_files_for_contact_do_not_depend_on_the_order_of_labels(name, matrix, pressed, tmp_path):
    labelled = ORDERS[name](matrix)
    ours = compressed(labelled)
    for number in ("p_max", "F_y", "M_x", "p", "estimate_p_max"):
        np.testing.assert_array_equal(ours[number], pressed[number])
    for file, each in (("one", matrix), ("other", labelled)):
        femic.write_for_contact(PAIR, each, tmp_path / file)
    one, other = ((tmp_path / file).read_text().split("\n\n")[-1] for file in ("one", "other"))
    assert one == other


NO_GRIDS = {  # by the message
    "no labels along i": lambda m: m.drop_vars("i"),
    "ic has the dimensions lag, observed, loaded, j: .* are needed": lambda m: m.sel(i="n"),
    "i = n, s: x, s, n are needed, each once": lambda m: m.sel(i=["n", "s"]),
    "i = n, s, s": lambda m: m.sel(i=["n", "s", "s"]),
    "j = 1, 2, 3": lambda m: m.assign_coords(j=["1", "2", "3"]),
    "no labels along observed": lambda m: m.drop_vars("observed"),
    "lag = .*lengths in mm": lambda m: m.drop_vars("lag").assign_coords(lag=list("abcdefghijklmn")),
    "loaded = .* the strips of observed": lambda m: m.isel(observed=slice(3, 9)),
    r"lag = 0, 1\.8, 3\.6, \.\.\.: 0, dx, 2 dx": lambda m: m.isel(lag=slice(None, None, 2)),
    r"lag = 0\.9, 1\.8": lambda m: m.isel(lag=slice(1, None)),
    "loaded = ": lambda m: m.assign_coords(loaded=m.loaded + 0.2),
    "lag = 0, 0.9, 0.9": lambda m: m.isel(lag=[0, 1, 1, 2]),
    "lag = 0, 0.0009": lambda m: m.assign_coords(lag=m.lag / 1e3),
    "ic: .* numbers are not finite": lambda m: m.where(m.observed > 0),
    "ic has the dimensions distance": lambda m: m.rename(lag="distance"),
    "without the variable ic": lambda m: m.rename(ic="c"),
    "estimate has the dimensions": lambda m: m.assign(estimate=m.estimate.max("lag")),
    "without attributes ds, dx, ics": lambda m: m.drop_attrs(),
    r"dx = '0\.9 mm'": lambda m: m.assign_attrs(dx="0.9 mm"),
}


@pytest.mark.parametrize(("message", "change"), NO_GRIDS.items())
def test_matrices_without_the_labels_of_a_grid_are_refused(message, change, matrix, tmp_path):
    with pytest.raises(femic.WrongInput, match=message):
        compressed(change(matrix))
    with pytest.raises(femic.WrongInput, match=message):
        femic.write_for_contact(PAIR, change(matrix), tmp_path / "contact.txt")


def test_a_labelled_array_of_another_grid_is_refused(matrix):
    with pytest.raises(femic.WrongInput, match=r"ics: strips from s = -2\.75, of the grid from -3\.15 mm"):
        femic.label_matrix(matrix.ic, replace(GRID, s=0.0), "mine")


@pytest.fixture(scope="module")
def ics():
    """ICs on two lines, with B-hat as C."""
    lines = [femic.line_along_x(1.6, 6.0, 9), femic.line_along_s(1.6, 6.0, 13)]
    with pytest.MonkeyPatch.context() as patch:
        b_hat_as_c(patch, 0.02)
        return femic.compute_ics(
            PAIR, femic.Patch(0.3, 0.2), lines, ["A", "C"], options=femic.Options(0.3, workers=1)
        )


ORDERS_OF_ICS = {
    "directions": lambda ics: ics.sel(i=["n", "s", "x"]),
    "dimensions": lambda ics: ics.transpose("point", ..., "variant"),
    "i and j exchanged": lambda ics: ics.transpose(..., "j", "i", "point"),
    "shuffled points": lambda ics: ics.isel(point=np.r_[0, 12, 1:12, 13:22]),
}


@pytest.mark.parametrize("order", ORDERS_OF_ICS.values(), ids=ORDERS_OF_ICS)
def test_errors_and_figures_of_ics_do_not_depend_on_the_order_of_labels(order, ics):
    for name in ("error", "rms", "weight", "vanishes"):
        xr.testing.assert_equal(femic.compare_ics(order(ics))[name], femic.compare_ics(ics)[name])
    assert drawn(femic.plot_ics(order(ics), "xn")) == drawn(femic.plot_ics(ics, "xn"))


def test_a_figure_of_ics_needs_its_component_alone(ics):
    assert drawn(femic.plot_ics(ics.sel(i=["x"], j=["n"]), "xn")) == drawn(femic.plot_ics(ics, "xn"))
    with pytest.raises(femic.WrongInput, match="component xn: no x along i"):
        femic.plot_ics(ics.sel(i=["n"]), "xn")
    with pytest.raises(femic.WrongInput, match="i = n: x, s, n are needed"):
        femic.compare_ics(ics.sel(i=["n"]))


@pytest.fixture(scope="module")
def loads():
    """Contacts without friction under two loads."""
    return femic.solve_contact(PAIR, femic.Frictionless([1e3, 4e3]), ["A", "Bhat"], SETUP)


def test_a_figure_of_contacts_has_the_pressures_of_its_cases(loads, pressed):
    for name, contact in (("case", loads), ("friction", pressed)):
        shuffled = np.random.default_rng(1).permutation(contact.sizes["s"])
        for same in (
            contact,
            contact.transpose("ics", ..., name),
            contact.isel(x=slice(None, None, -1), s=shuffled),
        ):
            xr.testing.assert_identical(contacts_by_label("contact", same), contact)
    exchanged = contacts_by_label("contact", loads.isel(case=[1, 0]))
    largest = [np.nanmax(pressure.values) for (pressure,) in surfaces(exchanged).steps.values()]
    np.testing.assert_array_equal(largest, loads.p_max.sel(ics="Bhat", case=[4e3, 1e3]))
    assert femic.plot_contact(pressed).axes[0].get_legend_handles_labels()[1]
    assert len(femic.plot_contact(loads.isel(case=[1])).axes) < len(femic.plot_contact(loads).axes)


def test_figures_of_contacts_refuse_what_has_lost_its_pressures_or_its_ics(loads):
    for lost, message in (
        (loads.drop_vars("p"), r"no variable p: give a whole dataset of solve_contact"),
        (loads.sel(ics="A"), r"no dimension ics with labels: .*\.sel\(ics=\['A'\]\) keeps ics"),
    ):
        with pytest.raises(femic.WrongInput, match=message):
            femic.plot_contact(lost)


def drawn(figure):
    """The curves of a figure."""
    return [line.get_xydata().tolist() for axes in figure.axes for line in axes.get_lines()]
