"""Realistic mistakes with public names: refused with the field and a remedy, and nothing is computed."""

import sys
from contextlib import suppress
from itertools import product
from pathlib import Path

import numpy as np
import pytest
import xarray as xr

import femic

sys.path.append(str(Path(__file__).parents[3] / "tools" / "attack"))
import mistakes
from mistakes import GRID, ICS, LINE, MATRIX, PAIR, PATCH, PRESSED, RAIL, RING, STEEL, WHEEL


def gap(**keys):
    """Solve with a setup."""
    return femic.solve_contact(PAIR, PRESSED, ["A"], femic.ContactSetup(**keys))


def ics(*arguments):
    """Compute ICs of the pair."""
    return femic.compute_ics(PAIR, *arguments)


MASKED = np.ma.masked_equal([0.0, 1.0, 2.0], 1.0)
FRAME = xr.Dataset({"gap": ("s", [0.0, 1.0]), "s": [0.0, 1.0]}).to_dataframe().reset_index()
MISTAKES = {  # one of each kind, by the field and the value, or what is allowed, as regular expressions
    "radius = '10': give a number": lambda: femic.arc("10", 60.0),
    "radius = nan": lambda: femic.arc(np.nan, 60.0),
    r"flank_inclination_deg = \(1\.0.*2 values": lambda: femic.arc(10.0, (1.0, 2.0, 3.0)),
    r"flank_inclination_deg\[1\] = None": lambda: femic.arc(10.0, (20.0, None)),
    r"y\[1\] = None: give numbers": lambda: femic.through_points([0, None, 2], [0, 0, 0]),
    r"y = \[\]: give at least one number": lambda: femic.through_points([], []),
    "y: rows have unequal lengths": lambda: femic.through_points([[0, 1], [2]], [0, 1]),
    r"y\[1\] = nan": lambda: femic.through_points(MASKED, [0, 0, 0]),
    "contour = None: give what is made with arc": lambda: femic.Body(None, STEEL),
    "material = the class Mat": lambda: femic.Body(femic.plane(), femic.Material),
    "outline = '60E1': .*dict": lambda: femic.Body(femic.plane(), STEEL, outline="60E1"),
    r"effective\['combined'\]": lambda: femic.Pair(WHEEL, RAIL, {"combined": 0.1}),
    r"points = 10\.5: give a whole number": lambda: femic.line_along_x(0.0, points=10.5),
    "x: a DataArray": lambda: femic.points(xr.DataArray(np.ones((2, 2))), 0.0),
    "lines = a LineAlongX: give a list": lambda: ics(PATCH, LINE, ["A"]),
    "patch = a Grid: give a femic.Patch": lambda: ics(GRID, [LINE], ["A"]),
    "ics = 'Bhat': give a list, each entry text": lambda: ics(PATCH, [LINE], "Bhat"),
    "store = 'foo://x': .*foo.*give a folder": lambda: femic.Options(store="foo://x"),
    "store = .*is a file: give a folder": lambda: femic.Options(store=__file__),
    "report = 'print': give a function": lambda: femic.Options(report="print"),
    r"longitudinal = 0\.001: give a list": lambda: femic.Rolling(1e3, 0.3, 0.001),
    r"friction_by_angle\[0\] = 0\.0: give 2 values": lambda: femic.Compression([1e3], 0.3, [0.0, 1.0]),
    "extra_gap: a DataFrame with columns s, gap: labels are not read here": lambda: gap(extra_gap=FRAME),
    "gap = 'precise': give 'linear' or 'exact'": lambda: gap(gap="precise"),
    r"motion = 1000\.0: give a femic.Frictionless": lambda: femic.solve_contact(PAIR, 1e3),
    r"estimate of shape \(\)": lambda: femic.label_matrix(MATRIX.ic, GRID, "mine", 0.02),
    "path = 'none/x.txt': no folder none: make it": lambda: femic.write_for_contact(
        PAIR, MATRIX, "none/x.txt"
    ),
    r"path = '\.': is a folder": lambda: femic.write_for_contact(PAIR, MATRIX, "."),
    "scene = 'flat': give what is made with load_sc": lambda: femic.run_scene("flat", "out"),
}


@pytest.fixture
def in_folder(monkeypatch, tmp_path):
    """Work in an empty folder."""
    monkeypatch.chdir(tmp_path)
    return tmp_path


@pytest.fixture
def computed():
    """What computes raises `Computed` instead."""
    with mistakes.computing_nothing():
        yield


@pytest.mark.usefixtures("computed")
@pytest.mark.parametrize(("message", "call"), MISTAKES.items())
def test_a_mistake_is_refused_with_its_field_before_any_work(message, call, in_folder):
    with pytest.raises(femic.WrongInput, match=message):
        call()
    assert not list(in_folder.iterdir())


WRONG_VALUES = (
    *(None, "", "text", "1", b"1", True, 0, -1, 1.5, 10**400, np.nan, np.inf, 1j, object(), print, iter([1])),
    *([], [None], ["x"], [[1, 2], [3]], [np.nan], [10**400], (1, 2, 3), {}, {"a": 1}, {1: 2}, range(3)),
    *(np.array(1.0), np.ones(3), np.ones((2, 2)), np.array(["a"]), np.array([]), xr.DataArray([1.0])),
    *(xr.Dataset(), MATRIX, ICS, PATCH, GRID, STEEL, PAIR, RAIL, LINE, RING, femic.Options(), femic.Options),
    *(Path("nowhere"), Path("/"), "/nonexistent/x.txt", "s3://b/x"),
)
OTHERS = {  # names of which no argument is tried
    *("plane", "FittedPair", "SolvedContact", "Failure", "WrongInput")
}
NAMES = [*mistakes.ARGUMENTS]


def test_all_public_names_are_tried():
    assert {public.__name__ for public in NAMES} - {"at"} == set(femic.__all__) - OTHERS


@pytest.mark.parametrize("public", NAMES, ids=lambda public: public.__name__)
def test_right_values_are_taken_and_wrong_ones_refused_with_field_and_value(public, in_folder):
    known = [*mistakes.mistakes_with(public)]
    assert known
    with mistakes.computing_nothing(), suppress(mistakes.Computed):
        public(**taken(public))
    for path in in_folder.iterdir():
        path.unlink()
    outcomes = [mistakes.outcome(mistake, in_folder) for mistake in known]
    assert not [(each.attack, each.short) for each in outcomes if each.short]


@pytest.mark.usefixtures("computed", "in_folder")
@pytest.mark.parametrize("public", NAMES, ids=lambda public: public.__name__)
def test_any_value_of_any_argument_is_taken_or_refused_as_documented(public):
    for name, value in product(taken(public), WRONG_VALUES):
        with suppress(femic.WrongInput, mistakes.Computed):
            public(**taken(public) | {name: value})


def taken(public):
    """Arguments that are taken."""
    return {name: argument.taken for name, argument in mistakes.ARGUMENTS[public].items()}
