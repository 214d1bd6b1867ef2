"""ICs in Python: those of the scene route, symmetries, errors from datasets, matrices, fits, figures."""

import html
import json
import re
from dataclasses import replace

import numpy as np
import pytest
import xarray as xr

import femic
from approx.pair import matrix
from femic.interface.matrices import matrix_grid
from femic.interface.options import make_scene
from femic.results.contact_file import read
from femic.results.ics import compute
from femic.results.ics_dataset import errors, to_dataset
from geometries.patches import COMPONENTS
from tests.femic.reference.stand_ins import b_hat_as_c
from tests.femic.scenes.changes import engine, patch

COARSE = 0.3  # tolerance, about where cells stop growing
PATCH = femic.Patch(a=0.3, b=0.2)
LINES = (femic.line_along_x(1.6, 6.0, 9), femic.line_along_s(1.6, 6.0, 13))
OPTIONS = femic.Options(tolerance=COARSE, workers=1)
NEAR = replace(OPTIONS, far_radius=60.0)
STORED = replace(OPTIONS, store="memory://ICs of geometry1")  # the scene's models are those of the pair
KEYS = {
    **patch(0.3, 0.2),
    "variants": ["A", "Bhat"],
    "lines": [
        {"along": "x", "s": 1.6, "reach": 6.0, "points": 9},
        {"along": "s", "x": 1.6, "reach": 6.0, "points": 13},
    ],
    "components": list(COMPONENTS),
    **engine(tolerance=COARSE, check=False),
}


@pytest.fixture(scope="module")
def pair():
    return femic.load_pair("geometry1")


@pytest.fixture(scope="module")
def ics(pair):
    """ICs with B-hat as C."""
    with pytest.MonkeyPatch.context() as patch:
        b_hat_as_c(patch)
        return femic.compute_ics(pair, PATCH, LINES, ("A", "Bhat", "C"), options=OPTIONS)


@pytest.fixture(scope="module")
def with_c(pair):
    """ICs with C itself, for slow tests."""
    return femic.compute_ics(pair, PATCH, LINES, ("A", "Bhat", "C"), options=STORED)


def test_ics_and_errors_of_a_pair_equal_those_of_its_scene(ics, monkeypatch):
    """By the scene's own route: errors from its results, not from the dataset."""
    b_hat_as_c(monkeypatch)
    results = compute(femic.load_scene("geometry1", KEYS), OPTIONS.run)
    dataset = to_dataset(results)
    for name in ("ic", "estimate", "raw"):
        xr.testing.assert_equal(ics[name], dataset[name])
        assert ics[name].attrs["units"] == "mm/N"
    assert ics.attrs["reference_length"] == 10.0
    ours, measured = femic.compare_ics(ics), errors(results, dataset)
    for name in ("error", "rms", "weight", "vanishes"):
        xr.testing.assert_allclose(ours[name], measured[name], rtol=1e-13)


def test_equal_bodies_have_no_combined_xn_of_a(ics):
    xn = ics.ic.sel(variant="A", i="x", j="n")
    np.testing.assert_allclose(xn.sel(body="upper"), -xn.sel(body="lower"), rtol=1e-13)
    assert np.all(xn.sel(body="combined") == 0)


@pytest.mark.slow
def test_c_of_a_pair_is_that_of_its_scene(with_c):
    results = compute(femic.load_scene("geometry1", KEYS), STORED.run)
    xr.testing.assert_equal(with_c.ic, to_dataset(results).ic)


@pytest.mark.slow
def test_c_is_symmetric_about_the_load_within_its_estimate(with_c):
    nn = with_c.sel(i="n", j="n", body="lower")
    across = nn.isel(point=nn.line.values == "x = 1.6 mm")
    c, estimate = across.ic.sel(variant="C").values, across.estimate.values
    assert np.all(np.abs(c - c[::-1]) <= estimate + estimate[::-1])
    assert np.all(estimate < 0.2 * np.abs(c).max())


def test_points_give_the_ics_of_a_line_through_them(pair):
    s = np.linspace(-6, 6, 13)
    names = ["A", "B", "Bbar", "Bhat", "mix"]
    on_line = femic.compute_ics(pair, PATCH, LINES[1:], names)
    scattered = femic.compute_ics(pair, PATCH, [femic.points(1.6, s, "mine"), LINES[0]], names)
    mine = scattered.isel(point=scattered.line.values == "mine")
    np.testing.assert_array_equal(mine.ic, on_line.ic)
    assert [str(name) for name in dict.fromkeys(scattered.line.values)] == ["mine", "s = 1.6 mm"]


@pytest.mark.slow
def test_single_body_and_component_agree_with_all(pair, with_c):
    one = femic.compute_ics(pair, PATCH, LINES, ["C"], bodies=["lower"], components=["nn"], options=OPTIONS)
    c, known = (with_c.sel(body="lower", i="n", j="n")[name] for name in ("ic", "estimate"))
    off = np.abs(one.ic.sel(variant="C", body="lower", i="n", j="n") - c.sel(variant="C"))
    assert np.all(off <= 2 * known)


def test_a_single_body_and_component_are_solved_alone_and_their_models_are_kept(pair, tmp_path):
    reports = []
    options = replace(NEAR, store=str(tmp_path / "store"), report=reports.append)
    results = [
        femic.compute_ics(
            pair, PATCH, LINES, ["Bhat", "C"], bodies=["lower"], components=["nn"], options=options
        )
        for _ in range(2)
    ]
    xr.testing.assert_equal(results[0].ic, results[1].ic)
    assert list(results[0].body.values) == ["lower"]
    domain = json.loads(results[0].attrs["domain"])["lower"]
    assert (domain["far_radius"], domain["truncated"]) == (60.0, False)
    assert bool(results[0].ic.sel(variant="C", j="x").isnull().all())
    c, b_hat = (results[0].ic.sel(body="lower", i="n", j="n", variant=name) for name in ("C", "Bhat"))
    assert float(abs(c - b_hat).max()) < COARSE * float(b_hat.max())
    assert len(list((tmp_path / "store").rglob("*.nc"))) >= 1


def test_a_far_arc_that_python_gives_is_a_support_and_the_default_one_is_not(pair):
    given, default = (make_scene(pair, options).bodies["upper"] for options in (NEAR, OPTIONS))
    assert (given.truncated, given.domain.far_radius) == (False, 60.0)
    assert default.truncated


@pytest.mark.parametrize(
    ("call", "message"),
    [
        (
            lambda pair: femic.compute_ics(pair, femic.Patch(0.3, 0.2, 9999.0), LINES, ["A"]),
            r"patch\.s = 9999",
        ),
        (lambda pair: femic.compute_ics(pair, PATCH, [femic.points(1e4, 0.0)], ["A"]), "lines.0"),
        (lambda pair: femic.compute_ics(pair, PATCH, LINES, ["Bhat_prime"]), "effective properties"),
        (lambda pair: femic.compute_matrix(pair, femic.Grid(4, 4, 1e3, 1.0), "A"), r"grid\.dx / grid\.ds"),
    ],
)
def test_wrong_input_is_refused_with_its_name_before_any_work(call, message, pair):
    with pytest.raises(femic.WrongInput, match=message):
        call(pair)


# --- matrices -------------------------------------------------------------------------------------------

GRID = femic.Grid(n_x=5, n_s=4, dx=0.6, ds=0.4, s=0.3)


@pytest.fixture(scope="module")
def c_matrix(pair):
    """C itself, for slow tests."""
    return femic.compute_matrix(pair, GRID, "C", OPTIONS)


def test_matrix_has_its_grid_and_layout(pair):
    labelled = femic.compute_matrix(pair, GRID, "B")
    again = matrix_grid(labelled)
    assert (again.n_x, again.n_s, again.dx, again.ds) == (5, 4, 0.6, 0.4)
    assert again.s == pytest.approx(0.3, rel=1e-12)
    scene = femic.load_scene("geometry1")
    np.testing.assert_array_equal(labelled.ic, matrix("B", scene.pair, GRID))
    assert labelled.ic.dims == ("lag", "observed", "loaded", "i", "j")


def test_c_of_a_matrix_is_the_sum_of_both_bodies_and_is_labelled_as_a_foreign_one(pair, monkeypatch):
    b_hat_as_c(monkeypatch, 0.02)
    c, b_hat = (femic.compute_matrix(pair, GRID, ics, OPTIONS) for ics in ("C", "Bhat"))
    np.testing.assert_allclose(c.ic, b_hat.ic, rtol=1e-9, atol=1e-12 * float(b_hat.ic.max()))
    assert float(c.estimate.max()) == pytest.approx(0.02 * float(c.ic.max()), rel=1e-6)
    assert c.attrs["ics"] == "C"
    xr.testing.assert_identical(femic.label_matrix(c.ic.values, GRID, "C", c.estimate.values), c)


@pytest.mark.slow  # of one body: tests/femic/reference/matrix
def test_c_of_a_matrix_is_reciprocal_and_near_b_hat(c_matrix, pair):
    """C(I, J) = C(J, I)^T at lag 0; B-hat of equal bodies comes close in nn, and has the signs of sn."""
    at_zero = c_matrix.isel(lag=0)
    known = float(c_matrix.estimate.max())
    swapped = at_zero.ic.values.transpose(1, 0, 3, 2)
    parity = np.outer([-1, 1, 1], [-1, 1, 1])
    assert np.abs(at_zero.ic.values - parity * swapped).max() <= 2 * known
    b_hat = femic.compute_matrix(pair, GRID, "Bhat")
    nn = {"i": "n", "j": "n"}
    largest = float(c_matrix.ic.sel(nn).max())
    off = np.abs(c_matrix.ic - b_hat.ic)
    assert float(off.sel(nn).max()) < 0.05 * largest
    sn = {"i": "s", "j": "n"}
    assert float(off.sel(sn).max()) < 0.5 * float(np.abs(c_matrix.ic).sel(sn).max())


@pytest.mark.slow  # that M_zz alone is taken: tests/femic/reference/test_discount_rules.py
def test_the_discount_takes_a_vertical_motion_from_c(c_matrix, pair):
    """Without it nn differs by M_zz of both bodies times the cosines at observer and load."""
    whole = femic.compute_matrix(pair, GRID, "C", OPTIONS, discount="none")
    cosine = np.cos(c_matrix.observed.values / 10.0)  # of an arc of 10 mm
    rigid = (whole.ic - c_matrix.ic).sel(i="n", j="n").values / np.outer(cosine, cosine)
    mean = np.mean(rigid)
    np.testing.assert_allclose(rigid, mean, rtol=0.05)  # C of another model, within its estimate
    assert abs(mean) > 1e-3 * float(c_matrix.ic.max())


def test_a_file_for_contact_has_the_matrix(pair, tmp_path):
    labelled = femic.compute_matrix(pair, GRID, "Bhat")
    femic.write_for_contact(pair, labelled, tmp_path / "contact.txt")
    shear = femic.load_scene("geometry1").pair.constants.G
    own = read(tmp_path / "contact.txt").values[:, GRID.n_s - 1]  # a strip on itself: (strip, lag, i, j)
    expected = shear * np.stack([labelled.ic.values[:, k, k] for k in range(GRID.n_s)])
    np.testing.assert_allclose(own, expected, rtol=1e-9, atol=1e-9 * np.abs(expected).max())


def test_distances_are_written_beside_the_ics_for_contact(tmp_path):
    """A wheel of R = 100 mm on a plane, 0.01 mm down: x^2 / (2 R) + s^2 / (2 r) - 0.01."""
    steel, r = femic.Material(E=210e3, nu=0.3), 40.0
    wheel = femic.Body(femic.arc(-r, 50.0), steel, rolling_radius=100.0)
    pair = femic.Pair(wheel, femic.Body(femic.plane(), steel), reference_length=10.0)
    grid = femic.Grid(6, 4, dx=0.2, ds=0.3)
    femic.write_for_contact(pair, femic.compute_matrix(pair, grid, "A"), tmp_path / "a.txt", approach=0.01)
    listed = np.loadtxt(tmp_path / "contact_distances.txt").reshape(4, 6)
    x, s = 0.2 * (np.arange(6) - 2.5), 0.3 * (np.arange(4) - 1.5)[:, None]
    np.testing.assert_allclose(listed, x**2 / 200 + s**2 / (2 * r) - 0.01, rtol=0, atol=1e-6)


# --- fits and figures -----------------------------------------------------------------------------------


@pytest.mark.slow  # of a scene: tests/compare/calibration; in Python: test_docs.py
def test_a_fit_gives_the_pair_a_b_hat_prime_that_is_closer_to_c(pair, with_c):
    fitted = femic.fit_bhat_prime(pair, PATCH, options=OPTIONS)
    prime = femic.compute_ics(fitted.pair, PATCH, LINES[:1], ["Bhat", "Bhat_prime"], bodies=["combined"])
    xn = prime.ic.sel(body="combined", i="x", j="n")
    c = with_c.ic.sel(variant="C", body="combined", i="x", j="n")
    c = c.isel(point=c.line.values == "s = 1.6 mm")
    off = np.abs(xn - c.values).max("point")
    assert off.sel(variant="Bhat_prime") < 0.3 * off.sel(variant="Bhat")
    assert set(fitted.pair.effective) == {"combined"}
    assert float(fitted.fit.rms.max()) < 0.1


@pytest.mark.parametrize("with_c", [True, False])
def test_a_figure_shows_all_ics_and_notebooks_show_it(ics, pair, with_c):
    shown = ics if with_c else femic.compute_ics(pair, PATCH, LINES, ["A", "Bhat"])
    figure = femic.plot_ics(shown, "sn")
    assert len(figure.axes) == 3 * len(LINES)
    labels = figure.axes[0].get_legend_handles_labels()[1]
    assert {"A", "B̂"} | ({"C"} if with_c else set()) <= set(labels)
    drawn = {line.get_label(): line.get_ydata() for line in figure.axes[0].get_lines()}
    on_line = shown.isel(point=shown.line.values == "s = 1.6 mm")
    expected = on_line.ic.sel(variant="Bhat", body="combined", i="s", j="n") * 210e3 * 10.0
    np.testing.assert_allclose(drawn["B̂"], expected, rtol=1e-12)
    for axes, along, line in zip(figure.axes[:2], "xs", ("s = 1.6 mm", "x = 1.6 mm"), strict=True):
        at = shown[along].values[shown.line.values == line] / 10.0
        np.testing.assert_allclose(axes.get_lines()[0].get_xdata(), at, atol=1e-12)
    assert figure._repr_png_().startswith(b"\x89PNG")
    assert html.unescape(explored(figure)["steps"][0][0]["title"]) == "sn, combined, s = 1.6 mm"


def explored(figure):
    """What a notebook gives to Plotly."""
    page = html.unescape(re.search(r'srcdoc="([^"]*)"', figure._repr_html_())[1])
    return json.loads(re.search(r'<script type="application/json">(.*?)</script>', page, re.DOTALL)[1])
