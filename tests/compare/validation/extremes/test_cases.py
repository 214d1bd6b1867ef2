"""The cases of `femic extremes`, their errors and reports of them; nothing is solved."""

import re
from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest

from compare.validation.extremes import engines
from compare.validation.extremes.cases import (
    HARMONIC,
    SOLID,
    BeyondLimit,
    Limit,
    WithinLimit,
    refusal,
    run_limits,
)
from compare.validation.extremes.engines import (
    component_errors,
    curved,
    flat,
    moduli,
    on_outline,
    ratio,
    solve_case,
    wheel,
    within_limit,
)
from femic.contact.loading import Loading
from femic.contact.normal import PotentialAreaTooSmall
from femic.reference.job import NotConverged
from geometries.errors import Failure, WrongInput
from geometries.patches import N, X
from tests.compare.validation.statements.handmade import made

# --- scenes ---------------------------------------------------------------------------------------------


def scene_of(case):
    """Of the harmonic engine, without a check by another."""
    return case.scene(HARMONIC)


def test_lines_of_a_plane_are_in_proportion_to_its_patch_and_off_its_outline():
    """b = 0.4 mm, a = 0.1 mm: beside it at 3 b, in front of it at 50 a, 25 b long."""
    scene = scene_of(flat(aspect=0.25, size=0.4, distance=50.0, beside=3.0))
    assert (scene.patch.a, scene.patch.b, scene.compared) == (0.1, 0.4, ("lower",))
    beside, through, across = scene.lines
    assert (beside.s[0], through.s[0], across.x[0]) == pytest.approx((1.2, 0.0, 5.0))
    for line in scene.lines:
        assert (line.running[0], line.running[-1]) == (-10.0, 10.0)
        assert len(line.x) >= engines.POINTS
        assert np.min(np.abs(line.running)) > 0
        assert np.min(np.abs(np.abs(line.running) - 0.1)) >= engines.DRAWN_AWAY * 0.1
    wide = scene_of(flat(aspect=4.0, size=0.2, distance=10.0))  # the distance is in its other half-side
    assert (wide.lines[2].x[0], wide.lines[0].x[-1]) == pytest.approx((2.0, 20.0))
    outline = scene_of(on_outline())
    for line, half_side in zip(outline.lines, (outline.patch.a, outline.patch.b), strict=True):
        assert np.min(np.abs(line.running - half_side)) < 1e-15
        assert np.min(np.abs(line.running + half_side)) < 1e-15
        assert line.running[-1] == pytest.approx(5 * half_side)


def test_planes_are_labelled_by_unusual_parameters():
    labels = [case.label for case in (flat(), flat(nu=0.4999), flat(aspect=0.01, distance=1000.0))]
    assert labels == ["", "ν = 0.4999", "a/b = 0.01, distance / half-side = 1000"]


def test_curved_cases_change_the_parameter_of_their_name():
    steep, small, huge, wide, stiff = map(
        scene_of, (curved(80.0), wheel(20.0), wheel(1e6), ratio(1.5), moduli(1e-3))
    )
    for body in steep.bodies.values():
        assert np.degrees(body.contour.inclination(25.0)) == pytest.approx(80)
    assert (small.bodies["upper"].rolling_radius, small.compared) == (20.0, ("upper",))
    assert [line.running[-1] for line in small.lines] == [4.0] * 3  # a fifth of the radius
    assert [line.running[-1] for line in huge.lines] == [25.0] * 3
    assert [wide.bodies[b].contour.inclination(1.0) for b in ("lower", "upper")] == pytest.approx(
        [1 / 10, 1 / 15]
    )
    assert (wide.compared, stiff.compared) == (("combined",), ("combined",))
    assert [stiff.bodies[b].material.E for b in ("lower", "upper")] == [210e3, 210.0]
    assert {scene.check for scene in (steep, small, huge, wide, stiff)} == {None}
    assert np.degrees(wide.bodies["upper"].contour.inclination(60.0)) == pytest.approx(25.5)


# --- errors and estimates -------------------------------------------------------------------------------


def plane_with(error, estimate=0.01, component=(N, N)):
    """The plane; C of both bodies off A by shares of the largest A_nn there is."""

    def c(of):
        out = of.a.copy()
        out[component] += error * np.max(of.a[N, N])
        return out

    return made("flat", c, estimate=estimate)


@pytest.mark.parametrize(
    ("error", "finer", "used"),
    [
        *((error, None, 1.2) for error in (0.012, -0.012)),  # C is known to 0.01 of the same scale
        (0.012, (0.010, 1.0), 0.2),  # the estimate is that of the coarser one
        (0.012, (0.012, 1.0), 0.0),
    ],
)
def test_errors_are_over_estimates_whatever_their_sign(error, finer, used):
    results, finer = plane_with(error), finer and plane_with(*finer)
    case = within_limit(flat(), results, finer)
    assert case.used == pytest.approx(used, abs=1e-9)
    assert (case.error > 0) == (used > 0)
    assert case.estimate > 0
    assert len(list(component_errors(results, finer))) == 3 * 6


def test_estimates_of_vanishing_components_count_as_rounding():
    """C_xn of equal bodies is 0: 5e-11 of the floor 0.05 is 1e-9 of its scale, and there is no estimate."""
    case = within_limit(flat(), plane_with(5e-11, estimate=0.0, component=(X, N)))
    assert case.estimate == 0
    assert case.used == pytest.approx(case.error / 1e-9)


@pytest.fixture
def solving(monkeypatch):
    """Return how to set errors of the next results; nothing is solved, and scenes are recorded."""

    def with_errors(*errors):
        remaining, scenes = iter(errors), []

        def compute(scene, _):
            scenes.append(scene)
            cost = SimpleNamespace(seconds={"mesh": 1.0, "solution": 0.5})
            results = plane_with(next(remaining))
            references = {name: replace(of, models={"fine": cost}) for name, of in results.references.items()}
            return replace(results, references=references)

        monkeypatch.setattr(engines, "compute", compute)
        return scenes

    return with_errors


@pytest.mark.parametrize(("engine", "tolerance"), [(HARMONIC, 0.01), (SOLID, 0.1)])
def test_planes_are_compared_with_a(engine, tolerance, solving):
    scenes = solving(0.005)
    reached = solve_case(engine, flat(nu=0.1), None)
    assert [(scene.settings.engine.name, scene.settings.tolerance) for scene in scenes] == [
        (engine, tolerance)
    ]
    assert (reached.at, reached.exact, reached.seconds) == ("ν = 0.1", "A", 3.0)
    assert reached.used == pytest.approx(0.5)
    assert reached.honest


def test_curved_bodies_are_compared_with_a_finer_c_of_the_harmonic_engine(solving):
    scenes = solving(0.012, 0.001)
    reached = solve_case(SOLID, curved(30.0), None)
    assert [scene.settings.engine.name for scene in scenes] == [SOLID, HARMONIC]
    assert scenes[1].settings.tolerance == 0.001
    assert {body.domain.far_radius for body in scenes[1].bodies.values()} == {3000.0}
    assert reached.exact == "a finer C"
    assert reached.used == pytest.approx(1.1)
    assert not reached.honest


def test_planes_are_drawn_within_their_ranges_and_the_worst_is_returned(solving):
    """The 29th is 3 estimates away in one component on every line, all others half of one."""
    scenes = solving(*(0.03 if k == 28 else 0.005 for k in range(40)))
    worst = engines.drawn_planes(None)
    assert worst.used == pytest.approx(3)
    assert worst.seconds == 3.0
    assert worst.note.startswith("40 scenes: 717 of 720 errors")  # of six components on three lines
    assert {scene.settings.engine.name for scene in scenes} == {HARMONIC}
    assert [scene.settings.tolerance for scene in scenes] == [(0.1, 0.01, 0.001)[k % 3] for k in range(40)]
    nu = np.array([scene.bodies["lower"].material.nu for scene in scenes])
    a, b = np.array([[getattr(scene.patch, side) for scene in scenes] for side in "ab"])
    beside = np.array([scene.lines[0].s[0] for scene in scenes]) / b
    for values, low, high in (
        (nu, 0, 0.49),
        (np.log10(a / b), -1, 1),
        (np.log10(b), -1, 0),
        (beside, 1.5, 8),
    ):
        cells = np.floor((values - low) / (high - low) * 40)  # a hypercube: one in each fortieth
        np.testing.assert_array_equal(np.sort(cells), np.arange(40))


VALUES = {  # of a scene, for the name of a parameter
    "ν": lambda scene: scene.bodies["lower"].material.nu,
    "patch aspect a/b": lambda scene: scene.patch.a / scene.patch.b,
    "distance / half-side": lambda scene: scene.lines[2].x[0] / min(scene.patch.a, scene.patch.b),
    "flank inclination": lambda scene: np.degrees(scene.bodies["lower"].contour.inclination(25.0)),
    "R_roll [mm]": lambda scene: scene.bodies["upper"].rolling_radius,
    "modulus ratio": lambda scene: scene.bodies["upper"].material.E / scene.bodies["lower"].material.E,
}


@pytest.mark.parametrize(("kind", "rows"), [(HARMONIC, engines._harmonic()), (SOLID, engines._solid())])
def test_cases_reach_both_ends_of_the_range(kind, rows):
    """The engine takes it all; an end of 0 of a distance and ends at infinity are not tried."""
    limits = engines.harmonic_limits() if kind == HARMONIC else engines.solid_limits()
    drawn = ["all of a plane at once"] if kind == HARMONIC else []
    assert [limit.name for limit in limits] == [*(name for name, *_ in rows), *drawn]
    named = {name: (allowed, within) for name, allowed, within, _ in rows}
    for name, value in VALUES.items():
        allowed, within = named[name]
        ends = [float(end) for end in re.findall(r"\d[\d.e-]*", allowed)]
        values = [value(case.scene(kind)) for case in within]
        tried = [end for end in ends if not (name.startswith("distance") and end == 0)]
        assert all(np.min(np.abs(np.array(values) - end)) <= 1e-9 * end for end in tried), name
        assert np.max(values) == pytest.approx(1e6 if "∞" in allowed else ends[-1])


# --- reports ---------------------------------------------------------------------------------------------


def raising(error, instead_of=None):
    """A call that raises an error, perhaps while it handles another one."""

    def call(_):
        try:
            raise instead_of or error
        except Failure:
            raise error  # noqa: B904

    return call


SHORT, STUCK = PotentialAreaTooSmall(("s < 0",), Loading(2.0)), NotConverged("3e-2")
CALLS = {  # a call, whether it fails, and the last line of what it says
    "taken": (lambda _: 0.3, False, ""),
    "wrong input": (
        raising(WrongInput("mine: 1 error(s)\n  lower.nu = 0.6: too")),
        False,
        "lower.nu = 0.6: too",
    ),
    "failure": (raising(Failure("no: a larger `tolerance`")), True, "no: a larger engine.tolerance"),
    "not converged": (raising(STUCK), True, "3e-2"),
    "not converged in place": (raising(STUCK, instead_of=SHORT), True, "3e-2"),
    "failure in place": (raising(Failure("the end"), instead_of=SHORT), False, "the end"),
    "failure in place of that": (raising(Failure("the end"), instead_of=STUCK), True, "the end"),
    "named in place": (raising(SHORT, instead_of=STUCK), False, str(SHORT)),
}


@pytest.mark.parametrize(("call", "failed", "text"), CALLS.values(), ids=CALLS)
def test_wrong_input_and_failures_that_a_case_names_are_refusals(call, failed, text):
    """A plain failure is of the kind that it was raised in place of."""
    result = refusal("here", call, (PotentialAreaTooSmall,))(None)
    assert result == BeyondLimit("here", text, failed=failed)


def test_each_case_is_reported_with_its_numbers_and_a_failed_one_has_an_infinite_error():
    said = []
    cases = (
        lambda _: WithinLimit("here", 1.2e-3, 2.5e-3, 1.0, "A", 1.26),
        lambda _: WithinLimit("there", 2.5e-3, 2.5e-3, np.nextafter(1, 2), "A", 0.0),
        lambda _: WithinLimit("in digits", 1e-15, None, None, "", 0.0),
        raising(Failure("no: a larger `tolerance`")),
    )
    row = Limit("harmonic", "ν", "0 … 1", cases, (lambda _: BeyondLimit("there", "no"),))
    options = SimpleNamespace(watch=SimpleNamespace(on_stage=said.append))
    (result,) = run_limits([row], options)
    assert said[0] == "  harmonic: ν: here: error 1.2e-03, estimate 2.5e-03, 1.3 s"
    assert said[2] == "  harmonic: ν: in digits: error 1.0e-15, 0.0 s"
    assert [case["honest"] for case in result["reached"]] == [True, False, True, False]
    failed = result["reached"][-1]
    assert (failed["error"], failed["used"], failed["note"]) == (None, None, "no: a larger engine.tolerance")
    assert result["beyond"] == [{"at": "there", "says": "no", "computed": False, "failed": False}]
