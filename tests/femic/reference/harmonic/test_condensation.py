"""Responses by condensed equations are those that fields have, and proved: what is wrong raises."""

from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest

from femic.reference.harmonic import elimination, engine, section_response
from femic.reference.harmonic.elimination import Eliminated, Elimination
from femic.reference.harmonic.engine import build_section
from femic.reference.harmonic.section import assemble
from femic.reference.harmonic.section_response import (
    LARGEST_RESIDUAL,
    Condensation,
    SectionSolver,
    observers,
    strip_force,
)
from femic.reference.job import NotConverged
from femic.reference.meshing import Cells
from femic.reference.symmetry import Parity, Y, parities
from geometries.bodies import Domain
from geometries.contours import arc
from geometries.patches import Load, Patch, X
from tests.femic.reference.harmonic.fields import fields
from tests.femic.reference.small_model import BODY, TASK

K = 0.3
SHARES = (1.0, 0.5)
WHOLE = replace(BODY, domain=Domain(12.0, np.inf))  # a small model
SYMMETRIC = replace(WHOLE, contour=arc(10.0, 0.3, 0.3))
CELLS = Cells(0.4, 0.7, 0.7)
LOADS = tuple(Load(Patch(0.4, 0.3, s), i) for s in (-1.5, 0.0, 0.2, 1.5) for i in range(3))
SEEN = {"few observers": np.array([-2.0, -1.0, 0.0, 0.5, 1.0, 2.0]), "many": np.linspace(-2.0, 2.0, 60)}


def largest(values):
    return np.max(np.abs(values))


@pytest.fixture(scope="module", autouse=True)
def fields_are_cheap():
    """So that 60 observers are many; it matters for nothing but seconds."""
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(section_response, "ROWS_PER_FIELD", 1)
        yield


CASES = {
    (body, seen): {"whole": WHOLE, "half": SYMMETRIC}[body] for body in ("whole", "half") for seen in SEEN
}
QUICK = {("whole", "few observers"), ("half", "many")}


@pytest.fixture(
    scope="module",
    params=[case if case in QUICK else pytest.param(case, marks=pytest.mark.slow) for case in CASES],
    ids=["-".join(case) for case in CASES],
)
def case(request):
    """A section and how many observers it has; two pairs are slow."""
    return request.param


@pytest.fixture(scope="module")
def section(case):
    found = build_section(replace(TASK.request, body=CASES[case], loads=LOADS, cells=CELLS))
    assert found.half_section == (case[0] == "half")
    return found


@pytest.fixture(scope="module")
def assembled(section):
    return assemble(section)


@pytest.fixture(scope="module")
def section_solver(section, case):
    """Responses at a few observers, which are carried along, or at many, at which fields are read."""
    seen = case[1]
    respond = SectionSolver(section, LOADS, SEEN[seen], SHARES)
    ((prepared, _),) = respond._shared  # one condensation serves all parities and far arcs
    assert prepared.by_fields == (seen == "many")
    return respond, SEEN[seen]


def by_fields(section, model, s, k, share):
    """Responses (load, 3, len(s)) of fields, part by part; all that lies beyond the far arc is held."""
    loads, nodes = LOADS, section.mesh.doflocs
    beyond = np.hypot(*nodes) > share * section.body.domain.far_radius
    u = np.zeros((len(loads), 3, len(s)))
    for y in (1, -1) if section.half_section else (0,):
        held = section.supported | beyond[:, None]
        if y:
            held |= (np.abs(nodes[0]) < 1e-9)[:, None] & (Parity(1, y).signs(Y) < 0)
        part = [j for j, load in enumerate(loads) if y in [p.y for p in parities(load, half_section=bool(y))]]
        force = np.stack([strip_force(section, loads[j], y) for j in part], axis=1)
        u[part] += (
            (observers(section, s, y) @ fields(model, held, k, force))
            .T.reshape(len(part), -1, 3)
            .swapaxes(1, 2)
        )
    axes = section.body.surface.axes(np.zeros_like(s), s)
    signs = np.array([[1, -1, -1] if load.direction == X else [1, 1, 1] for load in loads])
    return signs[..., None] * np.einsum("icn,lcn->lin", axes, u)


@pytest.mark.parametrize("k", [0.0, 0.02, pytest.param(0.3, marks=pytest.mark.slow), 8.0])
def test_responses_are_those_of_the_fields_with_either_far_arc(section, assembled, section_solver, k):
    """Loads and observers on both sides of y = 0, over it and beside it."""
    respond, s = section_solver
    (beside, responses), (_, residual) = respond([1.7, k], SHARES)
    assert beside.shape == responses.shape == (2, len(LOADS), 3, len(s))
    for found, share in zip(responses, SHARES, strict=True):
        expected = by_fields(section, assembled, s, k, share)
        assert largest(found - expected) < 1e-9 * largest(expected)
    assert 0 < residual < 1e-9
    if k == 0.02:
        assert largest(responses[0] - responses[1]) > 1e-3 * largest(responses)
    np.testing.assert_allclose(respond([k])[0][0], responses[:1], rtol=0, atol=1e-12 * largest(responses))


def test_supports_that_differ_at_many_nodes_are_factored_apart(section, section_solver, monkeypatch):
    together, s = section_solver
    monkeypatch.setattr(section_response, "MOST_RETAINED", 10)
    apart = SectionSolver(section, LOADS, s, SHARES)
    assert len(apart._shared) == (4 if section.half_section else 2)
    for shares in (SHARES, (1.0,), (0.5,)):
        expected = together([0.02], shares)[0]
        np.testing.assert_allclose(apart([0.02], shares)[0], expected, rtol=0, atol=1e-9 * largest(expected))


def test_the_unit_of_force_does_not_matter(section):
    """All moduli a million times as large: all responses a millionth."""
    harder = replace(section.body, material=replace(section.body.material, E=1e6 * section.body.material.E))
    soft, hard = (
        SectionSolver(replace(section, body=body), LOADS, SEEN["few observers"], SHARES)([K], SHARES)[0]
        for body in (section.body, harder)
    )
    assert largest(1e6 * hard - soft) < 1e-9 * largest(soft)


def test_residual_at_a_nearly_fixed_observer_is_a_share_of_the_amplitudes_at_the_loads(section):
    """At a distance of k s = 40 nothing is left but rounding."""
    responses, residual = SectionSolver(section, LOADS[-3:], np.array([-3.5]))([9.0])
    assert largest(responses) < 1e-6 * largest(SectionSolver(section, LOADS[-3:], np.array([1.5]))([9.0])[0])
    assert residual[0] < 1e-8


# --- what is wrong raises --------------------------------------------------------------------------------


@pytest.mark.parametrize("factor", [1.001, np.nan])
@pytest.mark.parametrize("wrong", ["one load or observer", "what is retained"])
def test_what_is_left_and_is_wrong_by_a_thousandth_raises(section_solver, monkeypatch, wrong, factor):
    """What one load does, what one observer sees, or the stiffness of what is retained."""
    respond, _ = section_solver
    prepared, right = respond._shared[0][0], Elimination.at
    r = prepared.elimination.retained
    places = [np.s_[:, :r, :r]]
    if wrong == "one load or observer":
        places = [np.s_[:, :, -1]] if prepared.by_fields else [np.s_[:, :, -1], np.s_[:, -1]]
    assert respond([0.0], SHARES)[1] < 1e-9
    for place in places:

        def changed_at(self, k, place=place):
            eliminated = right(self, k)
            left = eliminated.left.copy()
            left[place] *= factor
            return replace(eliminated, left=left)

        monkeypatch.setattr(Elimination, "at", changed_at)
        with pytest.raises(NotConverged, match=r"k = 0 1/mm, [\d,]{5,} unknowns.* residual is .*Try"):
            respond([0.0], SHARES)


@pytest.fixture
def changed(monkeypatch):
    """Let amplitudes be changed from here on."""
    fields = Eliminated.fields

    def start(change):
        monkeypatch.setattr(Eliminated, "fields", lambda *arguments: change(fields(*arguments)))

    return start


@pytest.mark.filterwarnings("ignore:invalid value encountered:RuntimeWarning")
@pytest.mark.parametrize("factor", [1.5, 0.0, np.nan, np.inf])
def test_displacements_that_are_wrong_raise(changed, section_solver, factor):
    def change(u):
        u[:, u.shape[1] // 2, -1] *= factor
        return u if np.isnan(factor) else factor * u

    changed(change)
    says = r"k = 0\.3 1/mm, [\d,]{5,} unknowns.* residual is .*1e-05 allowed.*Try"
    with pytest.raises(NotConverged, match=says):
        section_solver[0]([K])


def test_the_residual_grows_with_what_is_wrong(changed, section_solver):
    """A thousandth of the largest residual more of all solutions: the equations are that far from solved."""
    respond, _ = section_solver
    share, n = 0.1 * LARGEST_RESIDUAL, respond._shared[0][0].forces.shape[1]
    changed(lambda u: (1 + share) * u)
    assert share * np.sqrt(n) / 2 < respond([K])[1] < 2.5 * share * np.sqrt(n)


@pytest.fixture(scope="module")
def of_ten_decades(section):
    """Loads whose forces differ by ten decades, solved for their fields."""
    prepared = SectionSolver(section, LOADS, SEEN["many"])._shared[0][0]
    forces = prepared.forces.copy()
    forces.data *= np.geomspace(1e-5, 1e5, forces.shape[1])[forces.indices]
    return replace(prepared, forces=forces, elimination=replace(prepared.elimination, forces=forces))


def scale(column):
    def change(u):
        u[..., column] *= 1.001
        return u

    return change


@pytest.mark.parametrize(
    ("change", "residual"),
    [
        *((scale(column), r"\d\.\de-0[34]") for column in (0, 7, -1)),
        (lambda u: u[..., [1, 0, *range(2, u.shape[2])]], ""),
    ],
    ids=["the smallest", "another", "the largest", "two exchanged"],
)
def test_wrong_columns_raise_however_small_their_force(changed, of_ten_decades, change, residual):
    free = np.ones(of_ten_decades.elimination.retained, dtype=bool)
    assert of_ten_decades.respond([K], [free])[1] < 1e-9
    changed(change)
    with pytest.raises(NotConverged, match=f"residual is {residual}"):
        of_ten_decades.respond([K], [free])


@pytest.mark.parametrize("module", [elimination, section_response], ids=["eliminated", "retained"])
def test_pivots_of_zero_raise_with_remedies(section_solver, monkeypatch, module):
    """Where amplitudes are eliminated, or the free ones of what is retained."""

    def singular(*_):
        raise np.linalg.LinAlgError("Singular matrix")

    linalg = SimpleNamespace(**vars(np.linalg) | {"solve": singular})
    monkeypatch.setattr(module, "np", SimpleNamespace(**vars(np) | {"linalg": linalg}))
    with pytest.raises(NotConverged, match=r"k = 0\.3 1/mm.*Singular matrix.*Try"):
        section_solver[0]([K])


def test_the_worst_residual_of_all_parts_and_arcs_counts(section, section_solver, monkeypatch):
    """Also where each has its own equations."""
    _, s = section_solver
    monkeypatch.setattr(section_response, "MOST_RETAINED", 10)
    respond, respond_part, made = SectionSolver(section, LOADS, s, SHARES), Condensation.respond, []

    def recorded(*arguments):
        made.append(respond_part(*arguments)[0])
        return made[-1], np.zeros(1)

    monkeypatch.setattr(Condensation, "respond", recorded)
    respond([K], SHARES)
    for worst in range(len(made)):
        given = iter([(one, np.array([5e-9 if k == worst else 1e-12])) for k, one in enumerate(made)])
        monkeypatch.setattr(Condensation, "respond", lambda *_, given=given: next(given))
        assert respond([K], SHARES)[1] == 5e-9


# --- stored waves ----------------------------------------------------------------------------------------


class FakeWaves(dict):
    """Solved wavenumbers of an earlier run, (responses, residual), which can be changed."""

    put = dict.__setitem__

    @property
    def worst(self):
        return max(float(residual) for _, residual in self.values())


def test_cost_has_the_worst_residual_of_stored_waves_too():
    waves, few_waves = FakeWaves(), replace(TASK.request, body=WHOLE, accuracy=1e-7)
    first = engine.solve(few_waves, cache=waves, workers=2).cost.residual
    assert first == waves.worst
    assert 0 < first < 1e-9
    name = sorted(waves)[3]
    waves[name] = waves[name][0], 3e-7
    del waves["k0.0"]  # this one is solved again
    assert engine.solve(few_waves, cache=waves, workers=2).cost.residual == 3e-7
