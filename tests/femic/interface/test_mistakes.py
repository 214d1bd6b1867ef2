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
from mistakes import CONE, GAP, GRID, ICS, LINE, MATRIX, PAIR, PATCH, PRESSED, RAIL, RING, STEEL, WHEEL


def setup(**keys):
    """Solve with a setup."""
    return femic.solve_contact(PAIR, PRESSED, ["A"], femic.ContactSetup(**keys))


def ics(*arguments, **named):
    """Compute ICs of the pair."""
    return femic.compute_ics(PAIR, *arguments, **named)


MISTAKES = {  # the field and the value, or what is allowed, as regular expressions
    # contours
    "radius is text": (lambda: femic.arc("10", 60.0), "radius = '10': give a number"),
    "radius is NaN": (lambda: femic.arc(np.nan, 60.0), "radius = nan"),
    "radius is a list": (lambda: femic.arc([10.0], 60.0), r"radius = \[10\.0\]: give a number"),
    "radius is huge": (lambda: femic.arc(10**400, 60.0), "radius = 1000.*finite"),
    "three flanks": (lambda: femic.arc(10.0, (1.0, 2.0, 3.0)), r"flank_inclination_deg = \(1\.0.*2 values"),
    "one flank in a list": (lambda: femic.arc(10.0, [20.0]), r"flank_inclination_deg = \[20\.0\]"),
    "a flank is None": (lambda: femic.arc(10.0, (20.0, None)), r"flank_inclination_deg\[1\] = None"),
    "lengths differ": (
        lambda: femic.through_points([0, 1, 2], [0, 0]),
        r"y and z of shapes \(3,\) and \(2,\)",
    ),
    "a point is None": (
        lambda: femic.through_points([0, None, 2], [0, 0, 0]),
        r"y\[1\] = None: give numbers",
    ),
    "a point is NaN": (lambda: femic.through_points([0, 1, 2], [0, np.nan, 0]), r"z\[1\] = nan"),
    "no points": (lambda: femic.through_points([], []), r"y = \[\]: give at least one number"),
    "ragged points": (lambda: femic.through_points([[0, 1], [2]], [0, 1]), "y: rows of unequal length"),
    "points in a table": (lambda: femic.through_points([[0, 1], [1, 2]], [[0, 1], [1, 2]]), "two lists"),
    "one number": (lambda: femic.through_points(1.0, 2.0), "two lists"),
    "masked points": (
        lambda: femic.through_points(np.ma.masked_equal([0.0, 1.0, 2.0], 1.0), [0, 0, 0]),
        r"y\[1\] = nan",
    ),
    # bodies
    "contour is None": (lambda: femic.Body(None, STEEL), "contour = None: give what is made with arc"),
    "contour is a profile": (lambda: femic.Body(RING, STEEL), "contour = a Profile: give .*Profile.at"),
    "material is a number": (lambda: femic.Body(femic.plane(), 210e3), r"material = 210000\.0: .*Material"),
    "material is the class": (lambda: femic.Body(femic.plane(), femic.Material), "material = the class Mat"),
    "material and contour exchanged": (lambda: femic.Body(STEEL, femic.plane()), "contour = a Material"),
    "outline is text": (lambda: femic.Body(femic.plane(), STEEL, outline="60E1"), "outline = '60E1': .*dict"),
    "outline is unknown": (lambda: femic.Body(femic.plane(), STEEL, outline={"standard": "61E1"}), "61E1"),
    "body for a pair": (lambda: femic.Pair(WHEEL, STEEL), "lower = a Material: give a femic.Body"),
    "contours for a pair": (lambda: femic.Pair(femic.plane(), RAIL), "upper = .*: give a femic.Body"),
    "effective is a number": (lambda: femic.Pair(WHEEL, RAIL, {"combined": 0.1}), r"effective\['combined'\]"),
    "apart is text": (
        lambda: femic.Pair(WHEEL, RAIL, curvature_apart="no"),
        "curvature_apart = 'no': .*True",
    ),
    "pair is no scene": (lambda: femic.load_pair("nowhere.toml"), "nowhere.toml"),
    "pair is no word": (lambda: femic.load_pair(""), "scene"),
    # lines and points
    "line of halves": (lambda: femic.line_along_x(0.0, points=10.5), r"points = 10\.5: give a whole number"),
    "points that differ": (lambda: femic.points([1.0, 2.0], [1.0, 2.0, 3.0]), "x, s: .*shapes"),
    "points are labelled": (lambda: femic.points(xr.DataArray(np.ones((2, 2))), 0.0), "x: a DataArray"),
    "name is a number": (lambda: femic.points(0.0, 0.0, 3), "name = 3: give text"),
    # ICs
    "no lines": (lambda: ics(PATCH, [], ["A"]), r"lines = \[\]: give at least one entry"),
    "line in no list": (lambda: ics(PATCH, LINE, ["A"]), "lines = a LineAlongX: give a list"),
    "patch is a tuple": (lambda: ics((0.3, 0.2), [LINE], ["A"]), r"patch = \(0\.3, 0\.2\): .*femic.Patch"),
    "patch is a grid": (lambda: ics(GRID, [LINE], ["A"]), "patch = a Grid: give a femic.Patch"),
    "patch and lines exchanged": (lambda: ics([LINE], PATCH, ["A"]), "patch = "),
    "pair is a body": (lambda: femic.compute_ics(RAIL, PATCH, [LINE]), "pair = a Body: give a femic.Pair"),
    "ICs in no list": (lambda: ics(PATCH, [LINE], "Bhat"), "ics = 'Bhat': give a list, each entry text"),
    "no ICs": (lambda: ics(PATCH, [LINE], []), r"ics = \[\]"),
    "ICs are unknown": (lambda: ics(PATCH, [LINE], ["Hertz"]), "'Hertz'"),
    "bodies in no list": (lambda: ics(PATCH, [LINE], ["A"], bodies="lower"), "bodies = 'lower': give a list"),
    "bodies are unknown": (lambda: ics(PATCH, [LINE], ["A"], bodies=["rail"]), "'rail'"),
    "options are a mapping": (lambda: ics(PATCH, [LINE], ["A"], options={}), "options = {}: .*femic.Options"),
    "matrix for comparison": (lambda: femic.compare_ics(MATRIX), "ics: ic has the dimensions lag"),
    "variable for comparison": (lambda: femic.compare_ics(ICS.ic), "ics = a DataArray"),
    "nothing to compare": (lambda: femic.compare_ics(xr.Dataset()), "ics: .*without the variable ic"),
    # options
    "workers are halves": (lambda: femic.Options(workers=1.5), r"workers = 1\.5: give a whole number"),
    "workers are none": (lambda: femic.Options(workers=0), "workers = 0: at least 1"),
    "tolerance is in percent": (lambda: femic.Options(tolerance=5), "tolerance = 5.*at most 1"),
    "tolerance is text": (lambda: femic.Options(tolerance="1%"), "tolerance = '1%'"),
    "engine is unknown": (lambda: femic.Options(engine="fem"), "engine = 'fem': .*'harmonic' or 'solid'"),
    "store is unknown": (lambda: femic.Options(store="foo://x"), "store = 'foo://x': .*foo.*give a folder"),
    "store is a file": (lambda: femic.Options(store=__file__), "store = .*is a file: give a folder"),
    "report is text": (lambda: femic.Options(report="print"), "report = 'print': give a function"),
    # motions
    "loads in no list": (lambda: femic.Frictionless(1e3), r"loads = 1000\.0: give a list"),
    "loads are NaN": (lambda: femic.Frictionless([np.nan]), r"loads\[0\].*nan: give a finite number"),
    "loads are a table": (lambda: femic.Frictionless(np.ones((2, 2))), r"loads\[0\] = array of shape"),
    "friction is None": (lambda: femic.Rolling(1e3, None), "friction = None: give a number or a list"),
    "friction is negative": (lambda: femic.Rolling(1e3, -0.3), r"friction = -0\.3"),
    "load is negative": (lambda: femic.Rolling(-1e3, 0.3), r"load = -1000\.0"),
    "loads of rolling": (
        lambda: femic.Rolling([1e3, 2e3], 0.3),
        r"load = \[1000\.0, 2000\.0\]: give a number",
    ),
    "creepage in no list": (lambda: femic.Rolling(1e3, 0.3, 0.001), r"longitudinal = 0\.001: give a list"),
    "angles of friction": (
        lambda: femic.Rolling(1e3, 0.3, friction_by_angle=[(0.0, 1.0, 2.0)]),
        r"friction_by_angle\[0\] = ",
    ),
    "angles in one list": (
        lambda: femic.Compression([1e3], 0.3, [0.0, 1.0]),
        r"friction_by_angle\[0\] = 0\.0: give 2 values",
    ),
    "creepages of transient": (lambda: femic.TransientRolling(1e3, 0.3, [0.001]), r"creepage = \[0\.001\]"),
    # contact
    "gap is NaN": (lambda: setup(extra_gap=[[-1.0, np.nan], [1.0, 0.0]]), r"extra_gap\[0, 1\] = nan"),
    "gap is ragged": (lambda: setup(extra_gap=[[-1.0, 0.0], [1.0]]), "extra_gap: rows of unequal length"),
    "gap is wide": (lambda: setup(extra_gap=np.ones((3, 4))), r"extra_gap of shape \(3, 4\)"),
    "gap is transposed": (lambda: setup(extra_gap=np.ones((2, 9))), r"extra_gap of shape \(2, 9\)"),
    "gap at one point": (lambda: setup(extra_gap=[[0.0, 1.0]]), "extra_gap: one point: give two"),
    "gap twice": (lambda: setup(extra_gap=[[0.0, 1.0], [0.0, 2.0]]), "extra_gap: points 1 and 2"),
    "gap is a table": (
        lambda: setup(
            extra_gap=xr.Dataset({"gap": ("s", [0.0, 1.0]), "s": [0.0, 1.0]}).to_dataframe().reset_index()
        ),
        "extra_gap: a DataFrame with columns s, gap: its labels are not read",
    ),
    "gap is labelled": (lambda: setup(extra_gap=xr.DataArray(GAP)), "extra_gap: a DataArray"),
    "kind of gap": (lambda: setup(gap="precise"), "gap = 'precise': give 'linear' or 'exact'"),
    "grid is a tuple": (lambda: setup(grid=(8, 8, 0.5, 0.5)), r"grid = \(8, 8.*: give a femic.Grid"),
    "flanks are text": (lambda: setup(flanks="no"), "flanks = 'no': give True or False"),
    "contact of a load": (
        lambda: femic.solve_contact(PAIR, 1e3),
        r"motion = 1000\.0: give a femic.Frictionless",
    ),
    "contact of a class": (lambda: femic.solve_contact(PAIR, femic.Rolling), "motion = the class Rolling"),
    "contact with an IC": (lambda: femic.solve_contact(PAIR, PRESSED, "Bhat"), "ics = 'Bhat': give a list"),
    "contact with an array": (
        lambda: femic.solve_contact(PAIR, PRESSED, [MATRIX.ic.values]),
        r"ics\[0\] = array",
    ),
    "contact with a variable": (
        lambda: femic.solve_contact(PAIR, PRESSED, [MATRIX.ic]),
        r"ics\[0\] = a DataA",
    ),
    "contact with a matrix alone": (
        lambda: femic.solve_contact(PAIR, PRESSED, MATRIX),
        "ics = a Dataset: give a list",
    ),
    "contact with ICs at points": (
        lambda: femic.solve_contact(PAIR, PRESSED, [ICS.assign_attrs(ics="mine", dx=1.0, ds=1.0)]),
        "ic has the dimensions variant",
    ),
    "options before the setup": (
        lambda: femic.solve_contact(PAIR, PRESSED, ["A"], femic.Options()),
        "setup = an Options: give a femic.ContactSetup",
    ),
    # matrices
    "grid of halves": (lambda: femic.compute_matrix(PAIR, femic.Grid(4.5, 3, 0.6, 0.4), "A"), r"n_x = 4\.5"),
    "matrix of a list": (lambda: femic.compute_matrix(PAIR, GRID, ["A"]), r"ics = \['A'\]: give text"),
    "discount": (lambda: femic.compute_matrix(PAIR, GRID, discount="rigid"), "discount = 'rigid': give 'app"),
    "label NaN": (lambda: femic.label_matrix(np.full((4, 3, 3, 3, 3), np.nan), GRID, "m"), "ics.* = nan"),
    "label another shape": (
        lambda: femic.label_matrix(np.ones((4, 3, 3)), GRID, "m"),
        r"of shape \(4, 3, 3\)",
    ),
    "label without a name": (lambda: femic.label_matrix(MATRIX.ic, GRID, None), "name = None: give text"),
    "label a dataset": (lambda: femic.label_matrix(MATRIX, GRID, "mine"), "ics = a Dataset: give"),
    "label with a share": (
        lambda: femic.label_matrix(MATRIX.ic, GRID, "mine", 0.02),
        r"estimate of shape \(\)",
    ),
    "file of an array": (lambda: femic.write_for_contact(PAIR, MATRIX.ic.values, "x.txt"), "ics = array of"),
    "file without a folder": (
        lambda: femic.write_for_contact(PAIR, MATRIX, "none/x.txt"),
        "path = 'none/x.txt': no folder none: make it",
    ),
    "file that is a folder": (
        lambda: femic.write_for_contact(PAIR, MATRIX, "."),
        r"path = '\.': is a folder",
    ),
    # fits
    "fit of a property": (lambda: femic.fit_bhat_prime(PAIR, PATCH, properties=["E"]), "'E'"),
    "fit at lines": (lambda: femic.fit_bhat_prime(PAIR, [LINE]), "patch = "),
    # figures
    "figure of a contact": (lambda: femic.plot_contact(ICS), "contact: no dimension case"),
    "figure of a matrix": (lambda: femic.plot_ics(MATRIX), "ics: ic has the dimensions lag"),
    "figure of the component": (lambda: femic.plot_ics(ICS, "zz"), "component = 'zz': one of xx"),
    "figure of a file": (
        lambda: femic.plot_profile("rail.prr"),
        "profile = 'rail.prr': give a femic.Profile",
    ),
    # profiles
    "kind of profile": (
        lambda: femic.Profile("a.prr", kind="track"),
        "kind = 'track': give 'rail' or 'wheel'",
    ),
    "unit of profile": (lambda: femic.Profile("a.prr", unit=25.4), r"unit = 25\.4: give text"),
    "surface of profile": (lambda: femic.Profile("a.prr", surface=1.0), r"surface = 1\.0: give a whole"),
    "tolerance of profile": (
        lambda: femic.Profile("a.prr", tolerance="cv"),
        "tolerance = 'cv': .*'cross-val",
    ),
    "place is NaN": (lambda: RING.at(np.nan), "y_centre.*nan"),
    "inclination as a ratio": (lambda: RING.at(0.0, rail_inclination="1:40"), "rail_inclination = '1:40'"),
    "written name": (lambda: femic.write_profile("60E1", "x.prr"), "profile = '60E1': give a femic.Profile"),
    # wheelsets, scenes
    "rail is a name": (
        lambda: femic.compute_shifts("60E1", CONE, [0.0]),
        "rail = '60E1': give a femic.Profile",
    ),
    "shift in no list": (lambda: femic.compute_shifts(RING, CONE, 0.0), r"shifts = 0\.0: give a list"),
    "tables in a list": (
        lambda: femic.compute_shifts(RING, CONE, [0.0], tables=[]),
        r"tables = \[\]: .*dict",
    ),
    "rail and wheel exchanged": (
        lambda: femic.compute_shifts(CONE, RING, [0.0]),
        "rail = .cone-1-20.: the profile of a wheel",
    ),
    "scene is a name": (
        lambda: femic.run_scene("flat", "out"),
        "scene = 'flat': give what is made with load_sc",
    ),
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
@pytest.mark.parametrize(("call", "message"), MISTAKES.values(), ids=MISTAKES)
def test_a_mistake_is_refused_with_its_field_before_any_work(call, message, in_folder):
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
    *("plane", "FittedPair", "Failure", "WrongInput"),
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
