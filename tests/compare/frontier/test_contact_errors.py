"""Errors of contact numbers by hand: scales, the reference's own row, unknown shares, advice and refusals."""

from types import SimpleNamespace

import numpy as np
import pytest
import xarray as xr

from compare.pages.frontier import answer_table, error_text, summary
from compare.studies.contact_frontier import best_reference, contact_method, frontier_dataset, worst_estimate
from compare.studies.frontier import APPROXIMATION, AS_CHEAP, Question, advise, worst
from femic.contact.motions import MOTIONS
from femic.contact.specification import ContactSpecification, FrictionSpecification
from femic.scenes.wants import chosen_wants, default_names, wants_of
from geometries.errors import Failure, WrongInput

LOAD, FRICTIONS, CREEPAGES = 1000.0, (0.2, 0.5), (-0.01, 0.0, 0.01)
BEST = contact_method("C", "harmonic", 20, 0.01)
CLOSE, FAR = (contact_method(ics, APPROXIMATION, 10) for ics in ("Bhat", "A"))
ROLLING = {want.name: want for want in MOTIONS["rolling"].wants}


def numbers(**changes):
    """Numbers of a rolling contact with two coefficients of friction, at three creepages."""
    values = {
        "p_max": [[900.0, 1000.0, 900.0], [1800.0, 2000.0, 1800.0]],
        "F_x": [[-150.0, 4.0, 150.0], [-400.0, 10.0, 400.0]],
        "sliding_share": [[0.8, 0.5, 0.8], [0.6, 0.25, 0.6]],
        "zero_creepage": [0.0001, 0.0002],
        "slope": [40e3, 50e3],
    }
    estimates = {
        "p_max": [[9.0, 5.0, 9.0], [9.0, 10.0, 9.0]],
        "F_x": [[3.0, 1.0, 3.0], [4.0, 0.5, 4.0]],
        "sliding_share": [[0.02] * 3, [0.01] * 3],
        "zero_creepage": [1e-5, 1e-5],
        "slope": [400.0, 500.0],
    }
    values |= {name: value for name, value in changes.items() if name in values}
    estimates |= {name[9:]: value for name, value in changes.items() if name.startswith("estimate_")}
    dimensions = {1: ("case",), 2: ("case", "point")}
    arrays = {
        prefix + name: (dimensions[np.ndim(array)], np.array(array))
        for prefix, table in (("", values), ("estimate_", estimates))
        for name, array in table.items()
    }
    limit = ("case", LOAD * np.array(FRICTIONS))
    case = ("case", list(FRICTIONS), {"units": "1"})
    return xr.Dataset(arrays | {"limit": limit}, {"case": case, "point": list(CREEPAGES)})


CLOSE_NUMBERS = numbers(
    p_max=[[900.0, 1010.0, 891.0], [1800.0, 2000.0, 1800.0]],
    F_x=[[-150.0, 10.0, 153.0], [-400.0, 30.0, 420.0]],
    sliding_share=[[0.8, 0.54, 0.8], [0.6, 0.25, 0.6]],
    zero_creepage=[0.0003, 0.0002],
    slope=[42e3, 50e3],
)
FAR_NUMBERS = numbers(p_max=[[990.0, 1100.0, 990.0], [1800.0, 2000.0, 1800.0]])
SECONDS = {BEST: 100.0, CLOSE: 2.0, FAR: 1.0}


def frontier(names=tuple(ROLLING), solutions=None):
    """The frontier of a handmade contact."""
    all_numbers = solutions or {BEST: numbers(), CLOSE: CLOSE_NUMBERS, FAR: FAR_NUMBERS}
    solved = {
        way: of_way.assign(ics_seconds=0.0, operator_seconds=0.0, contact_seconds=SECONDS[way], strips=8)
        for way, of_way in all_numbers.items()
    }
    wants = [ROLLING[name] for name in names if ROLLING[name].number in all_numbers[BEST]]
    attributes = {"motion": "rolling", "title": "By hand", "skipped": "{}", "scene": ""}
    return frontier_dataset(solved, wants, BEST).assign_attrs(attributes)


def value(dataset, name, number, way=CLOSE, case=0.2):
    return dataset[name].sel(way=way.name, number=number, case=case).item()


def test_scales_by_hand():
    dataset = frontier()
    # 1 % at zero creepage and at the last one, where the reference is known to 1 % instead of 0.5 %
    assert value(dataset, "error", "p_max") == pytest.approx(0.01)
    assert value(dataset, "bound", "p_max") == pytest.approx(0.02)
    # of the force: at zero creepage, 4 ± 1 N, no share of the force is known; 3 N of 150 N, known to 3 N
    assert value(dataset, "error", "F_x") == pytest.approx(0.02)
    assert value(dataset, "bound", "F_x") == pytest.approx(0.04)
    # of friction times load, 200 N: 6 N at zero creepage; 3 N, known to 3 N, weigh less than 6 N known to 1 N
    assert value(dataset, "error", "F_x/limit") == pytest.approx(0.03)
    assert value(dataset, "bound", "F_x/limit") == pytest.approx(0.035)
    assert value(dataset, "error", "sliding_share") == pytest.approx(0.04)
    # the slope of 40 kN reaches 200 N at a creepage of 0.005
    assert value(dataset, "error", "zero_creepage") == pytest.approx(0.0002 / 0.005)
    assert value(dataset, "bound", "zero_creepage") == pytest.approx(0.00021 / 0.005)
    assert value(dataset, "error", "slope") == pytest.approx(0.05)


def test_forces_are_judged_as_shares_of_themselves_where_they_are_known():
    """4 N known to 1 N are not; 10 N known to 0.5 N are, and are off by 200 %."""
    dataset = frontier()
    assert list(dataset.judged.sel(number="F_x").values) == [2, 3]
    assert list(dataset.points.sel(number="F_x").values) == [3, 3]
    assert list(dataset.judged.sel(number="F_x/limit").values) == [3, 3]
    assert value(dataset, "error", "F_x", case=0.5) == pytest.approx(2.0)
    assert value(dataset, "bound", "F_x", case=0.5) == pytest.approx(2.05)


def test_row_of_the_reference_is_its_estimate():
    dataset, own = frontier(), numbers()
    for name, scale in {
        "p_max": abs(own.p_max),
        "F_x": abs(own.F_x).isel(point=[0, 2]),
        "F_x/limit": own.limit,
        "sliding_share": 1.0,
        "zero_creepage": own.limit / own.slope,
        "slope": own.slope,
    }.items():
        estimate = value(dataset, "estimate", name, BEST)
        assert value(dataset, "error", name, BEST) == value(dataset, "bound", name, BEST) == estimate > 0
        shares = (own[f"estimate_{ROLLING[name].number}"] / scale).sel(case=0.2)
        assert estimate == pytest.approx(float(shares.max())), name


def test_no_error_is_smaller_than_what_the_reference_is_known_to():
    same = frontier(solutions={BEST: numbers(), CLOSE: numbers()})
    for name in map(str, same.number.values):
        errors = worst(same, [name]).sel(way=CLOSE.name)
        own = worst(same, [name]).bound.sel(way=BEST.name)
        assert errors.error == errors.bound == own > 0
        assert error_text(errors).startswith("≤ ")
    with_errors = worst(frontier(), ["F_x/limit"]).sel(way=CLOSE.name)
    assert (with_errors.case, with_errors.number) == (0.5, "F_x/limit")  # 20 of 500 N, ± 0.5 N


def test_a_way_without_a_solution_at_one_creepage_is_no_way():
    gone = numbers(p_max=[[np.nan, 1000.0, 900.0], [1800.0, 2000.0, 1800.0]])
    dataset = frontier(solutions={BEST: numbers(), CLOSE: gone, FAR: FAR_NUMBERS})
    assert np.isnan(worst(dataset, ["p_max"]).bound.sel(way=CLOSE.name))
    assert worst(dataset, ["p_max"], 0.5).bound.sel(way=CLOSE.name) > 0
    # where the reference has no solution nothing is compared
    other = frontier(solutions={BEST: gone, CLOSE: numbers()})
    assert list(other.judged.sel(number="p_max").values) == [2, 3]
    assert worst(other, ["p_max"]).bound.sel(way=CLOSE.name) > 0


def test_best_reference_has_the_smallest_of_worst_estimates():
    """The worst of the handmade ones: slope, p_max 1 %; F_x 3 N of 200 N; sliding 0.02."""
    wants = [want for name, want in ROLLING.items() if want.number in numbers()]
    assert worst_estimate(numbers(), wants) == pytest.approx(0.02)
    unknown = numbers(estimate_slope=[np.nan, 500.0])
    assert worst_estimate(unknown, wants) == np.inf


@pytest.mark.parametrize(
    ("wanted", "best"), [("p_max", "pressures"), ("slope", "slope"), ("F_x", "slope"), ("F_x/limit", "slope")]
)
def test_the_reference_is_the_c_that_knows_best_what_is_wanted(wanted, best, monkeypatch):
    """F_x may vanish, and has the same estimates in both: then the worst of all numbers decides."""
    references = {
        contact_method("C", "pressures"): numbers(estimate_p_max=[[1.0] * 3] * 2, estimate_slope=[4e3, 5e3]),
        contact_method("C", "slope"): numbers(estimate_slope=[40.0, 50.0]),
    }
    wants = [want for name, want in ROLLING.items() if want.number in numbers()]
    monkeypatch.setattr("compare.studies.contact_frontier.wants_of", lambda _: wants)
    scene = SimpleNamespace(contact=None)
    assert best_reference(references, [ROLLING[wanted]], scene).kind == best


@pytest.mark.parametrize("tolerance", [0.01, 0.02, 0.05, 0.105, 0.2])
@pytest.mark.parametrize("wants", [("p_max",), ("F_x/limit",), ("p_max", "F_x/limit", "sliding_share")])
def test_advice_is_the_cheapest_way_within_the_tolerance(wants, tolerance):
    dataset = frontier()
    bounds = {
        way: max(
            float(dataset.bound.sel(way=way.name, number=name, case=case))
            for name in wants
            for case in dataset.case.values
        )
        for way in SECONDS
    }
    good = [way for way, bound in bounds.items() if bound <= tolerance]
    if not good:
        with pytest.raises(
            Failure,
            match=r"no choice of ICs is within .* The most accurate, .* has an error of up .*elements$",
        ):
            advise(dataset, Question(wants, tolerance))
        dataset.attrs["skipped"] = '{"C 0.01": "about 9 s, but 3 s of the budget are left", "mix": "no fit"}'
        with pytest.raises(Failure, match=r", or a larger --budget; the present budget excluded C 0\.01$"):
            advise(dataset, Question(wants, tolerance))
        return
    fastest = min(SECONDS[way] for way in good)
    as_cheap = [way for way in good if SECONDS[way] <= AS_CHEAP * fastest]
    chosen = min(as_cheap, key=bounds.__getitem__)
    advice = advise(dataset, Question(wants, tolerance))
    assert (advice.way, advice.bound) == (chosen.name, pytest.approx(bounds[chosen]))
    assert advice.changes["contact"] == {"ics": [chosen.ics], "elements": chosen.elements}
    assert advice.changes.get("engine") == (None if np.isnan(chosen.tolerance) else {"tolerance": 0.01})


def test_advice_says_where_a_force_is_not_judged_and_what_to_want_where_it_vanishes():
    advice = advise(frontier(), Question(("F_x",), 0.5))
    assert "F_x is evaluated at 5 of 6 points" in advice.text
    vanishing = numbers(F_x=np.full((2, 3), 1e-9), estimate_F_x=np.full((2, 3), 1e-9))
    dataset = frontier(solutions={BEST: vanishing, CLOSE: vanishing})
    with pytest.raises(
        Failure, match=r"F_x: it nowhere exceeds .* want F_x/limit, which is relative to friction"
    ):
        advise(dataset, Question(("F_x",), 0.5))
    assert "F_x" not in [head.head for head in answer_table(dataset).heads]


def test_summary_names_the_ways_and_the_reference():
    dataset = frontier(("p_max", "F_x/limit"))
    text = summary(dataset)
    assert text.startswith("Cheapest ICs within the tolerance of 2 %: for p_max, B̂, 10 elements in ")
    assert "relative to C (0.01), 20 elements, whose estimated error is at most " in text
    rows = {row.name: row.filled[0] for row in answer_table(dataset).rows}
    assert [rows[name].text for name in ("2 %", "1 %")] == ["B̂, 10 elements", "C (0.01), 20 elements"]


FRICTION = FrictionSpecification(coefficients=(0.2,))


@pytest.mark.parametrize(
    ("specification", "name", "message"),
    [
        (ContactSpecification(loads=(1.0,)), "p_mx", "no such number; did you mean 'p_max'"),
        (ContactSpecification(loads=(1.0,)), "F_x", "not of contact.motion = 'none', but of 'rolling'"),
        (ContactSpecification(loads=(1.0,)), "load", "prescribed by the scene: one of p_max, .*approach"),
        (ContactSpecification(approaches=(1.0,)), "approach", "prescribed by the scene"),
        (ContactSpecification(), "p_max", "the scene has no contact: give .contact. loads"),
        (
            ContactSpecification(motion="transient", loads=(1.0,), friction=FRICTION),
            "p_max",
            "contact.motion = 'transient': ICs are compared with motion = 'none' or 'rolling'",
        ),
    ],
)
def test_numbers_that_a_contact_has_not_are_refused(specification, name, message):
    with pytest.raises(WrongInput, match=f"want = .*{name}.*{message}"):
        chosen_wants(specification, [name])


def test_prescribed_numbers_are_not_wanted():
    def names(**keys):
        return {want.name for want in wants_of(ContactSpecification(**keys))}

    assert names(loads=(1.0,)) & {"approach", "load", "F_y/load", "position/b"} == {"approach", "F_y/load"}
    assert names(approaches=(1.0,)) & {"approach", "load"} == {"load"}
    assert names(loads=(1.0,), lateral_force=0.1) & {"F_y/load", "position/b"} == {"position/b"}
    assert default_names(ContactSpecification(loads=(1.0,))) == ("p_max",)
    rolling = ContactSpecification(motion="rolling", loads=(1.0,), friction=FRICTION)
    assert default_names(rolling) == ("p_max", "F_x")


@pytest.mark.parametrize("tolerance", [0.0, -0.1, 1.5, np.nan])
def test_tolerances_out_of_range_are_refused(tolerance):
    with pytest.raises(WrongInput, match=r"--tolerance .*: must be above 0 and at most 1"):
        Question(("p_max",), tolerance)
    with pytest.raises(WrongInput, match="name at least one number"):
        Question((), 0.1)
