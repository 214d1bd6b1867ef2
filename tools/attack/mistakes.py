"""Realistic mistakes with the public names of Python: each is refused with the field and the value.

Each argument of each public name has a value that is taken, and values that are wrong by their kind: of
another type, not finite, out of range, of another length or shape, empty, unknown, another noun. Arguments
are also left out, misspelt, and exchanged with their neighbours. What is wrong ends with a message of femic,
before any work and without a file: never with a result, nor with a message from inside a library.
"""

import random
import warnings
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import ExitStack, chdir, contextmanager
from dataclasses import dataclass
from datetime import date
from decimal import Decimal
from inspect import signature
from itertools import pairwise
from pathlib import Path
from typing import Any
from unittest.mock import Mock, patch

import numpy as np
import xarray as xr
from fuzz import limited
from outcomes import Outcome

import femic
from femic.tables.columns import CONTACT as QUANTITIES
from femic.tables.columns import FORCES
from femic.tables.creep_table import AXES

STEEL = femic.Material(E=210e3, nu=0.3)
PLANE = femic.plane()
WHEEL = femic.Body(femic.arc(10.6, 60.0), STEEL, rolling_radius=500.0)
RAIL = femic.Body(femic.arc(10.0, 60.0), STEEL)
PAIR = femic.Pair(WHEEL, RAIL)
PATCH = femic.Patch(0.3, 0.2)
LINE = femic.line_along_x(1.6, 6.0, 9)
GRID = femic.Grid(n_x=4, n_s=3, dx=0.6, ds=0.4)
PRESSED = femic.Frictionless([1e3])
RING = femic.Profile(standard="60E1")
CONE = femic.Profile(standard="cone-1-20")
MATRIX = femic.compute_matrix(PAIR, GRID, "A")
MINE = femic.label_matrix(MATRIX.ic, GRID, "mine")
ICS = femic.compute_ics(PAIR, PATCH, [LINE], ["A", "Bhat"]).assign_coords(variant=["A", "C"])
ICS["estimate"] = 0.01 * abs(ICS.ic.sel(variant="C", drop=True))  # with B-hat as C
CONTACT = femic.solve_contact(PAIR, PRESSED, ["A"], femic.ContactSetup(elements=8))
GAP = [[-1.0, 0.0], [1.0, 1e-3]]
TABLE = xr.Dataset(  # of creep forces, all 1
    {name: (AXES[:2], np.ones((1, 1))) for name in QUANTITIES}
    | {name: (AXES, np.ones((1, 1, 1, 1, 8, 3))) for name in FORCES},
    coords={axis: [1.0] for axis in AXES[:4]} | {"angle": np.arange(8) / 8, "creepage": [0.0, 0.5, 1.0]},
)
COMPUTE = {  # what computes, by the module that calls it
    "femic.interface.ics": ("compute", "approximations_dataset", "calibrate"),
    "femic.interface.matrices": ("matrices",),
    "femic.interface.contact": ("compute_contact", "compute_with_friction"),
    "femic.interface.solver": ("grids.grids_of",),
    "compare.interface": ("run.run_scene",),
    "femic.interface.profiles": ("wheelset.compute_shifts",),
    "femic.interface.tables": ("tables.compute_table", "tables.write_table"),
}


LARGEST = 1e300  # of numbers that a float can have
WORDS_FOR = {"name_or_path": "scene"}  # in messages
TOGETHER = ("give either", "must increase")  # of what keys mean together
OF_ARRAYS = ("of shape", "of shapes", "rows have unequal lengths", "one point")
OF_LABELLED = ("dataset", "dimension", "labels along", "without", "no variable", "no coordinate")


class Computed(BaseException):
    """Something was computed."""


@contextmanager
def computing_nothing() -> Iterator[None]:
    """Raise `Computed` in what computes."""
    with ExitStack() as stack:
        for module, names in COMPUTE.items():
            for name in names:
                place = f"{module}.{name}"
                stack.enter_context(patch(place, Mock(side_effect=Computed)))
        yield


# --- values that are wrong, by the kind of an argument ---------------------------------------------------

NOTHING = (None,)
NOT_FINITE = (float("nan"), float("inf"), -float("inf"), 10**400)
NO_NUMBER = (
    *("", "10", "10 mm", b"10", True, 10j, [10.0], (10.0,), {10.0}, {"value": 10.0}, np.array([10.0, 11.0])),
    *(np.array([10.0]), np.array("10"), Decimal("10"), date(2026, 1, 1), print, object(), STEEL, float),
)
NUMBER = NO_NUMBER + NOT_FINITE
POSITIVE = (*NUMBER, 0.0, -1.0)
WHOLE = (*(value for value in POSITIVE if value is not NOT_FINITE[3]), 1.5, np.float64(9.0), "9.0", 0, -3)
TRUTH = (0, 1, 1.0, float("nan"), "", "no", "False", b"yes", [], [True], np.array([True, False]), {}, STEEL)
NO_TEXT = (3, 1.5, True, b"A", ["A"], ("A",), {"A"}, {"A": 1}, np.array(["A", "B"]), STEEL, str, print)
WORD = (*NO_TEXT, "", " ", "zz", "Hertz", "nn,xn")
PATH = (*NO_TEXT, float("nan"))
NO_LIST = (1.0, "1.0", {1.0}, {"a": 1.0}, iter([1.0]), (value for value in (1.0,)), STEEL, print, list)
NUMBERS = (
    *NO_LIST,
    *(["1.0"], [None], [True], [1j], [[1.0]], [b"1"], [1.0, "2.0"], [1.0, None], [STEEL], np.ones((2, 2))),
    *([float("nan")], [1.0, float("inf")], [10**400], np.array(["1.0"]), np.array(1.0)),
)
LIST_OF_WORDS = (
    *(3, 1.5, "A", "nn", {"A"}, {"A": 1}, iter(["A"]), [], (), [1], [None], [b"A"], [["A"]], [True]),
    *(["zz"], [""], ["A", None], ["nn", 3], STEEL, np.array(["A", "zz"]), np.array(1.0)),
)
ARRAY = (
    *("1.0", "", b"1", True, 1j, {"a": 1.0}, {1.0}, iter([1.0]), STEEL, print, float, [], np.array([])),
    *(["0", "1"], [None, 1.0], [True, False], [1j, 1.0], [[0.0, 1.0], [2.0]], [STEEL], np.array(["a", "b"])),
    *([0.0, float("nan")], [0.0, float("inf")], [10**400, 1.0], xr.DataArray(np.ones((2, 2)))),
    *(np.ma.masked_equal([0.0, 1.0], 1.0), date(2026, 1, 1), [date(2026, 1, 1)]),
)
MAPPING = (3, 1.5, "text", "", [], [("a", 1)], True, STEEL, dict, print, {1: 2}, {"unknown": 1})
NOUNS = (STEEL, PLANE, RAIL, PAIR, PATCH, LINE, GRID, PRESSED, RING, femic.Options(), femic.ContactSetup())
DATASET = (
    *(
        3,
        1.5,
        "results.nc",
        Path("results.nc"),
        b"",
        True,
        [],
        {},
        {"ic": 1},
        STEEL,
        PAIR,
        np.ones((2, 3, 3)),
    ),
    *(xr.DataArray([1.0]), xr.Dataset(), xr.Dataset, [MATRIX], ICS.ic, ICS.drop_vars("ic"), CONTACT.p_max),
    *(ICS.rename(ic="c"), ICS.isel(i=0), ICS.drop_vars("j"), MATRIX.ic, MATRIX.isel(lag=0)),
    *(MATRIX.rename(lag="x"), MATRIX.drop_vars("i"), CONTACT.drop_vars("p_max"), CONTACT.isel(ics=0)),
)


def noun(kind: type, *more: Any) -> tuple[Any, ...]:
    """Return what is no noun of a kind."""
    others = [other for other in NOUNS if not isinstance(other, kind)]
    return (3, 1.5, "text", b"text", True, [], {}, kind, print, xr.Dataset(), *others, *more)


@dataclass(frozen=True)
class Argument:
    """An argument: a value that is taken, and values that are wrong."""

    taken: Any
    wrong: Sequence[Any]


def needed(taken: Any, *wrong: Any) -> Argument:
    """Return an argument that may not be None."""
    return Argument(taken, (None, *wrong))


FLANKS = [value for value in NUMBER if not isinstance(value, list | tuple | np.ndarray)]
FLANKS += [[20.0], (20.0,), (20.0, 30.0, 40.0), (20.0, None), ("20", 30.0), (20.0, float("nan")), -91.0, 90.0]
BY_ANGLE = (
    *(1.0, "0", {0.0: 1.0}, iter([(0.0, 1.0)]), [0.0, 1.0], [(0.0,)], [(0.0, 1.0, 2.0)], [(0.0, "1")]),
    *([(0.0, None)], [(float("nan"), 1.0)], [(0.0, float("inf"))], [(0.0, -1.0)], [(-1.0, 1.0)]),
    *([(40.0, 1.0), (20.0, 0.3)], [None], ["01"], STEEL),
)
LOADS = (*NUMBERS, None, [0.0], [-1.0], [1e3, -1e3], [1e300])
FRICTION = (
    *("0.3", b"0.3", True, 0.3j, {0.3}, {"a": 0.3}, iter([0.3]), [], ["0.3"], [None], [0.3, None], [[0.3]]),
    *(STEEL, print, 0.0, -0.3, [0.3, 0.0], 1001.0, *NOT_FINITE, [float("nan")]),
)
CREEPAGE = (*NUMBER, 1.0, -1.0, 2.0)
OPTIONS = noun(femic.Options)
NUMBER_OR_NONE = [value for value in POSITIVE if value is not None]
ARGUMENTS: Mapping[Callable[..., Any], Mapping[str, Argument]] = {
    femic.Material: {"E": needed(210e3, *POSITIVE), "nu": needed(0.3, *NUMBER, -0.1, 0.51, 30)},
    femic.Patch: {"a": needed(0.3, *POSITIVE), "b": needed(0.2, *POSITIVE), "s": needed(0.0, *NUMBER)},
    femic.Grid: {
        "n_x": needed(4, *WHOLE),
        "n_s": needed(3, *WHOLE),
        "dx": needed(0.6, *POSITIVE),
        "ds": needed(0.4, *POSITIVE),
        "s": needed(0.0, *NUMBER),
    },
    femic.load_scene: {
        "name_or_path": needed("flat", *PATH, "", "flatt", "nowhere.toml", Path("nowhere")),
        "changes": Argument(
            None, (*MAPPING, {"lower": 1.0}, {"lower": {"E": "210e3"}}, {"lower": {"nu": 0.6}}, {"lowr": {}})
        ),
    },
    femic.arc: {"radius": needed(10.0, *NUMBER, 0.0), "flank_inclination_deg": needed(60.0, *FLANKS)},
    femic.ellipse: {
        "b_el": needed(10.0, *POSITIVE),
        "d_el": needed(9.0, *POSITIVE),
        "flank_inclination_deg": needed((60.0, 50.0), *FLANKS),
    },
    femic.through_points: {
        "y": needed(
            [0.0, 1.0, 2.0, 3.0],
            *(*ARRAY, 1.0, [0.0, 1.0, 2.0], [0.0, 2.0, 1.0, 3.0], [0.0, 1.0, 1.0, 3.0], [3.0, 2.0, 1.0, 0.0]),
            np.ones((4, 2)),
        ),
        "z": needed([0.0] * 4, *ARRAY, 1.0, [0.0, 1.0, 2.0], np.ones((4, 2))),
        "y_centre": needed(1.0, *NUMBER, -10.0, 10.0),
    },
    femic.Body: {
        "contour": needed(PLANE, *noun(type(PLANE))),
        "material": needed(STEEL, *noun(femic.Material)),
        "rolling_radius": needed(460.0, *(value for value in POSITIVE if value is not NOT_FINITE[1]), -460.0),
        "hub_radius": Argument(None, (*POSITIVE, 460.0, 500.0)),
        "outline": Argument(None, (*MAPPING, {"standard": "61E1"}, {"standard": 60}, {"kind": "rail"})),
    },
    femic.Pair: {
        "upper": needed(WHEEL, *noun(femic.Body)),
        "lower": needed(RAIL, *noun(femic.Body)),
        "effective": needed({}, *MAPPING, {"combined": 0.1}, {"combined": None}, {"combined": {"nu": 0.3}}),
        "curvature_apart": needed(False, *TRUTH, True),
        "reference_length": Argument(None, POSITIVE),
    },
    femic.load_pair: {"name_or_path": needed("flat", *PATH, "", "flatt", "nowhere.toml", Path("nowhere"))},
    femic.line_along_x: {
        "s": needed(0.0, *NUMBER),
        "reach": needed(5.0, *POSITIVE),
        "points": needed(9, *WHOLE, 1),
    },
    femic.line_along_s: {
        "x": needed(0.0, *NUMBER),
        "reach": needed(5.0, *POSITIVE),
        "points": needed(9, *WHOLE, 1),
    },
    femic.points: {
        "x": needed([0.0, 1.0], *ARRAY, [1.0, 2.0, 3.0]),
        "s": needed([0.0, 1.0], *ARRAY, [1.0, 2.0, 3.0]),
        "name": needed("mine", *NO_TEXT),
    },
    femic.compute_ics: {
        "pair": needed(PAIR, *noun(femic.Pair)),
        "patch": needed(PATCH, *noun(femic.Patch), (0.3, 0.2)),
        "lines": needed([LINE], *NO_LIST, LINE, [], [None], [1.6], ["x"], [LINE, None], [PATCH], [[LINE]]),
        "ics": needed(["A"], *LIST_OF_WORDS, ["A", "A"], ["a"]),
        "bodies": needed(["lower"], *LIST_OF_WORDS, ["rail"], ["lower", "lower"]),
        "components": needed(["nn"], *LIST_OF_WORDS, ["nx", "N"], ["nn", "nn"]),
        "options": needed(femic.Options(), *OPTIONS),
    },
    femic.compare_ics: {
        "ics": needed(ICS, *DATASET, ICS.sel(variant=["A"]), ICS.drop_vars("estimate"), MATRIX, CONTACT)
    },
    femic.Options: {
        "tolerance": needed(0.01, *POSITIVE, 5.0, 1.5),
        "engine": needed("harmonic", *WORD, "fem", "Harmonic"),
        "far_radius": Argument(None, POSITIVE),
        "most_unknowns": needed(10_000, *WHOLE, 1e6),
        "workers": needed(1, *WHOLE),
        "store": Argument(None, (*PATH, __file__, "foo://x")),
        "report": Argument(None, (3, 1.5, True, "print", [print], {}, STEEL, [])),
    },
    femic.Frictionless: {
        "loads": Argument([1e3], LOADS),
        "approaches": Argument((), (*LOADS, [1e-3])),
        "lateral_force": Argument(None, NUMBER),
    },
    femic.Rolling: {
        "load": needed(1e3, *POSITIVE, [1e3, 2e3]),
        "friction": needed(0.3, *FRICTION),
        "longitudinal": needed([-1e-3, 1e-3], *NUMBERS, [0.0], [], [1.0], [-1.0], [0.0, 2.0]),
        "lateral": needed(0.0, *CREEPAGE),
        "spin": needed(0.0, *NUMBER, 1.1, -2.0),
        "equal_force": needed(0.5, *NUMBER, 1.5, -1.5),
        "friction_by_angle": needed((), *BY_ANGLE),
    },
    femic.TransientRolling: {
        "load": needed(1e3, *POSITIVE, [1e3, 2e3]),
        "friction": needed(0.3, *FRICTION),
        "creepage": needed(0.1, *CREEPAGE, [0.001]),
        "lateral": needed(0.0, *CREEPAGE),
        "spin": needed(0.0, *NUMBER, 1.1, -2.0),
        "distance": Argument(None, POSITIVE),
        "friction_by_angle": needed((), *BY_ANGLE),
    },
    femic.Compression: {
        "loads": needed([1e3], *LOADS, [], [2e3, 1e3], [1e3, 1e3]),
        "friction": needed(0.3, *FRICTION),
        "friction_by_angle": needed((), *BY_ANGLE),
    },
    femic.ContactSetup: {
        "elements": needed(8, *WHOLE, 7, 65, 1000),
        "grid": Argument(None, (*noun(femic.Grid), (8, 8, 0.5, 0.5), {"n_x": 8})),
        "shift": needed(0.0, *NUMBER),
        "flanks": needed(True, *TRUTH),
        "gap": needed("linear", *WORD, "precise", "Linear"),
        "extra_gap": Argument(
            GAP,
            (
                *(*ARRAY, 1.0, "gap.csv", Path("gap.csv"), [0.0, 1.0], np.ones((2, 9)), np.ones((3, 4))),
                *([[0.0, 1.0]], [[0.0, 1.0], [0.0, 2.0]], [[0.0, None], [1.0, 0.0]], np.ones((2, 3, 3))),
            ),
        ),
    },
    femic.solve_contact: {
        "pair": needed(PAIR, *noun(femic.Pair)),
        "motion": needed(PRESSED, *noun(femic.Frictionless), 1e3, [1e3], "rolling", femic.Rolling),
        "ics": needed(
            ["A"], *LIST_OF_WORDS, ["A", "A"], MATRIX, [MATRIX.ic], [MATRIX.ic.values], [ICS], [xr.Dataset()]
        ),
        "setup": needed(femic.ContactSetup(), *noun(femic.ContactSetup), {"elements": 8}),
        "options": needed(femic.Options(), *OPTIONS),
    },
    femic.ContactSolver: {
        "pair": needed(PAIR, *noun(femic.Pair)),
        "load": needed(1e3, *POSITIVE, [1e3, 2e3]),
        "ics": needed("A", *WORD, ["A"], ["A", "B"], MATRIX.ic, MATRIX.ic.values, ICS, xr.Dataset()),
        "setup": needed(femic.ContactSetup(), *noun(femic.ContactSetup), {"elements": 8}),
        "options": needed(femic.Options(), *OPTIONS),
    },
    femic.compute_table: {
        "pair": needed(PAIR, *noun(femic.Pair)),
        "loads": needed([1e3], *NUMBERS, [-1.0], [2e3, 1e3], [1e3, 1e3]),
        "shifts": Argument([0.0], (*NUMBERS, [1.0, 0.0])),
        "friction": Argument([0.3], (*NUMBERS, [-0.1], [3.0], [0.4, 0.3])),
        "spin": Argument(1.0, (*NUMBER, -1.0, 11.0)),
        "ics": Argument("A", (*WORD, ["A"], MATRIX)),
        "tolerance": Argument(0.03, (*NUMBER, 0.0, 0.7)),
        "elements": Argument(12, (*WHOLE, 7, 33)),
        "setup": Argument(femic.ContactSetup(), (*noun(femic.ContactSetup), femic.ContactSetup(shift=1.0))),
        "options": needed(femic.Options(), *OPTIONS),
    },
    femic.read_table: {"table": needed(TABLE, *PATH, "nowhere.nc", "nowhere.txt", MATRIX, xr.Dataset())},
    femic.write_table: {
        "table": needed(TABLE, *DATASET),
        "folder": needed("out", *PATH),
    },
    femic.compute_matrix: {
        "pair": needed(PAIR, *noun(femic.Pair)),
        "grid": needed(GRID, *noun(femic.Grid), (4, 3, 0.6, 0.4)),
        "ics": needed("A", *WORD, ["A"], MATRIX),
        "options": needed(femic.Options(), *OPTIONS),
        "discount": needed("none", *WORD, "rigid", "None"),
    },
    femic.label_matrix: {
        "ics": needed(
            MATRIX.ic,
            *(*ARRAY, MATRIX, np.ones((4, 3, 3)), np.ones((3, 3, 4, 3, 3)), np.full((4, 3, 3, 3, 3), np.nan)),
            *(MATRIX.ic[1:], MATRIX.ic.drop_vars("lag"), MATRIX.ic.rename(lag="x"), MATRIX.ic * np.nan, 1.0),
            *(np.ones((5, 3, 3, 3, 3)), MATRIX.ic.assign_coords(lag=2 * MATRIX.lag)),
        ),
        "grid": needed(GRID, *noun(femic.Grid)),
        "name": needed("mine", *NO_TEXT),
        "estimate": Argument(None, (*ARRAY, 0.02, np.ones((4, 3, 3)), MATRIX.ic[1:], MATRIX)),
    },
    femic.write_for_contact: {
        "pair": needed(PAIR, *noun(femic.Pair)),
        "ics": needed(MINE, *DATASET, ICS, CONTACT, "A", MINE.drop_attrs(), MINE.isel(lag=[0, 2])),
        "path": needed("mine.txt", *PATH, ".", "none/x.txt", "a\0b", "n" * 300),
        "approach": Argument(None, NUMBER),
    },
    femic.fit_bhat_prime: {
        "pair": needed(PAIR, *noun(femic.Pair)),
        "patch": needed(PATCH, *noun(femic.Patch), [LINE]),
        "bodies": needed(["combined"], *LIST_OF_WORDS, ["rail"], ["lower", "lower"]),
        "properties": needed(["mismatch_k"], *LIST_OF_WORDS, ["E"]),
        "components": needed(["xn"], *LIST_OF_WORDS),
        "curvature_apart": needed(False, *TRUTH),
        "options": needed(femic.Options(), *OPTIONS),
    },
    femic.plot_ics: {"ics": needed(ICS, *DATASET, MATRIX, CONTACT), "component": needed("nn", *WORD, "NN")},
    femic.plot_contact: {"contact": needed(CONTACT, *DATASET, ICS, MATRIX)},
    femic.plot_profile: {"profile": needed(RING, *noun(femic.Profile), "rail.prr")},
    femic.Profile: {
        "file": Argument(None, (*PATH, "nowhere.prr", Path("nowhere"), "", ".", "60E1")),
        "standard": Argument("60E1", (*WORD, None, "61E1", "60e2", "rail.prr")),
        "kind": Argument(None, (*WORD, "track", "rail")),
        "axes": Argument(None, (*WORD, "centre")),
        "unit": Argument(None, (*WORD, 25.4, "mm")),
        "surface": Argument(None, (*WHOLE, 1)),
        "section": Argument(None, (*WHOLE, 1)),
        "section_at": Argument(None, (*NUMBER, 1.0)),
        "tolerance": needed(0.0, *NUMBER, -1.0, 2.0, "cv", 0.01),
    },
    RING.at: {
        "y_centre": Argument(0.0, (*NUMBER, 1000.0, None)),
        "s_centre": Argument(None, (*NUMBER, 1.0)),
        "rail_inclination": needed(0.0, *NUMBER, "1:40", 40.0),
        "turn_deg": needed(0.0, *NUMBER, 1000.0),
        "steepest_deg": needed(85.0, *POSITIVE, 95.0, 850.0),
    },
    femic.write_profile: {
        "profile": needed(RING, *noun(femic.Profile), "60E1"),
        "path": needed("mine.prr", *PATH, ".", "none/x.prr", "mine.xyz", "a\0b.prr"),
    },
    femic.compute_shifts: {
        "rail": needed(RING, *noun(femic.Profile), "60E1", CONE),
        "wheel": needed(CONE, *noun(femic.Profile), "S1002", RING),
        "shifts": needed([0.0], *NUMBERS, [], [1.0, 0.0], [0.0, 0.0], [1000.0]),
        "tables": Argument(
            None,
            (
                *(*MAPPING, {"tracks": {}}, {"track": 1435.0}, {"track": {"gauge": "1435"}}),
                *({"track": {"gauge": None}}, {"track": {"guage": 1435.0}}, {"contact": {"ics": "A"}}),
                *({"contact": {"ics": ["zz"]}}, {"contact": {"load": 0.0}}, {"contact": {"load": "90e3"}}),
                *({"contact": {"elements": 20.5}}, {"wheelset": {"nominal_radius": [460.0]}}),
                *(
                    {"wheelset": {"nominal_radius": 0.46}},
                    {"rail": {"nu": 30}},
                    {"rail": {"E": float("nan")}},
                ),
                *({"rolling": {"friction": 30.0}}, {"rolls": [0.0, 1.0]}, {"shifts": "0"}),
            ),
        ),
        "options": needed(femic.Options(), *OPTIONS),
    },
    femic.run_scene: {
        "scene": needed(
            femic.load_scene("flat"), *noun(type(femic.load_scene("flat"))), "flat", Path("flat")
        ),
        "out": needed("out", *PATH),
        "options": needed(femic.Options(), *OPTIONS),
    },
}


# --- mistakes --------------------------------------------------------------------------------------------


@dataclass(frozen=True)
class Mistake:
    """A call with a mistake; of each tuple of texts one has to be in its message."""

    name: str
    call: Callable[[], Any]
    said: Sequence[Sequence[str]]


def mistakes(folder: Path, count: int, seed: int) -> Iterator[Outcome]:
    """Yield random ones of all mistakes, each once."""
    known = [mistake for public in ARGUMENTS for mistake in mistakes_with(public)]
    random.Random(seed).shuffle(known)
    with chdir(folder):
        for mistake in known[:count]:
            yield outcome(mistake, folder)


def mistakes_with(public: Callable[..., Any]) -> Iterator[Mistake]:
    """Yield the mistakes with a public name."""
    arguments, own = ARGUMENTS[public], public.__name__
    taken = {name: argument.taken for name, argument in arguments.items()}
    for name, argument in arguments.items():
        for k, value in enumerate(argument.wrong):
            keys = taken | {name: value}
            yield Mistake(
                f"{own}: {name} {k}", _call(public, keys), (tuple(_fields(name, value)), tuple(_signs(value)))
            )
    for (name, one), (other, two) in pairwise(arguments.items()):
        kinds = {tuple if isinstance(each, list) else type(each) for each in (one.taken, two.taken)}
        if len(kinds | {type(None)}) == 3:
            keys = taken | {name: two.taken, other: one.taken}
            yield Mistake(f"{own}: {name} and {other} exchanged", _call(public, keys), ((name, other),))
    for name, parameter in signature(public).parameters.items():
        keys = {key: value for key, value in taken.items() if key != name}
        if parameter.default is parameter.empty:
            yield Mistake(f"{own}: without {name}", _call(public, keys), ((own,), (name,)))
        misspelt = f"{name}_"
        keys[misspelt] = taken[name]
        yield Mistake(f"{own}: {misspelt}", _call(public, keys), ((own,), (misspelt, name)))
    yield Mistake(f"{own}: too many", lambda: public(*taken.values(), 1), ((own,),))


def _call(public: Callable[..., Any], keys: Mapping[str, Any]) -> Callable[[], Any]:
    return lambda: public(**keys)


def outcome(mistake: Mistake, folder: Path) -> Outcome:
    """Return what femic answers to a mistake: refused, or a warning, with the field and the value."""
    with warnings.catch_warnings(record=True) as told:
        warnings.simplefilter("always")
        try:
            with limited(), computing_nothing():
                mistake.call()
            answer, message = "warned" if told else "taken", "\n".join(str(each.message) for each in told)
        except Computed:
            answer, message = "taken", ""
        except (femic.WrongInput, femic.Failure, TypeError) as error:
            answer, message = "refused", str(error)
        except Exception as error:  # whatever it is, nobody is told which argument is wrong
            return Outcome(mistake.name, "traceback", f"{type(error).__name__}: {error}"[:300])
    if answer == "taken":
        return Outcome(mistake.name, answer, "is taken without a word")
    for texts in mistake.said:
        if not any(text in message for text in texts):
            return Outcome(mistake.name, answer, f"{' or '.join(texts)} is not in: {message}"[:300])
    if left := [path.name for path in folder.iterdir()]:
        return Outcome(mistake.name, answer, f"{left[0]} was written")
    return Outcome(mistake.name, answer)


def _fields(name: str, value: Any) -> Iterator[str]:
    """Yield texts of which a message about an argument has one: its name, or keys of a mapping."""
    yield WORDS_FOR.get(name, name)
    yield name
    if isinstance(value, Mapping):
        yield from map(str, value)


def _signs(value: Any) -> Iterator[str]:
    """Yield texts of which a message about a value has one: itself, its class, its shape, or an entry."""
    yield str(value) if isinstance(value, Path) else repr(value)[:40]
    yield from TOGETHER
    if isinstance(value, str) and value.strip():
        yield value
    if isinstance(value, type):
        yield value.__name__
    if not isinstance(value, bool | int | float | str | bytes | None):
        yield type(value).__name__
        yield getattr(value, "standard", repr(value)[:40])
    if isinstance(value, xr.Dataset | xr.DataArray):
        yield from OF_LABELLED
    if isinstance(value, np.ndarray | xr.DataArray | list | float):
        yield from OF_ARRAYS
    if isinstance(value, np.ndarray | xr.DataArray):
        value = [*np.unique(value).tolist(), float("nan")]  # masked numbers are none
    if isinstance(value, int | float):
        yield f"{float(value):g}" if abs(value) < LARGEST else "finite"
    if isinstance(value, Mapping):
        value = [*value, *value.values()]
    if isinstance(value, list | tuple):
        for entry in value:
            yield from _signs(entry)
