"""Contact by finite elements beside contact with ICs: numbers, approaches, storage, refusals.

The finite elements themselves are tested in tests/femic/contact; here others are in their place.
"""

from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest

from compare.pages.contact import write_contact
from compare.pages.finite_elements import differences, estimates, stored_solution
from femic.cache.store import Store
from femic.contact.finite_elements import CELLS
from femic.contact.finite_elements.result import FEContact, Numbers
from femic.reference.discount import FZ
from femic.reference.run_options import RunOptions
from femic.results import finite_elements as compute
from femic.results.contact import compute_contact
from femic.results.finite_elements import FE, compute_fe_contact, require_suitable, stored_fe_contact
from femic.scenes.errors import BadScene
from geometries.bodies import Domain
from geometries.errors import Failure, WrongInput
from tests.femic.contact.wheel_on_rail import scene

LOADS = [2e3, 5e3, 1e4]
COMPLIANCE = {"lower": 5e-7, "upper": -2e-7}  # mm/N, rigid part of that of both bodies
RIGID = sum(COMPLIANCE.values())
SIDEWAYS = 0.1  # lateral force over load
KNOWN = 0.01
NO_STORE = RunOptions()
SOLVED = {}  # by the text of a scene


def by_fe(of, options=NO_STORE, cells=CELLS):
    return compute_fe_contact(of, with_ics(of), options, cells)


def with_ics(of):
    """Contact of a scene with ICs, solved once; how bodies are supported does not matter."""
    if of.text not in SOLVED:
        SOLVED[of.text] = compute_contact(of)
    return SOLVED[of.text]


def pressed(**contact):
    return scene(10.3, **{"loads": LOADS, "ics": ["A", "Bhat"]} | contact)


@pytest.fixture(scope="module")
def by_bhat():
    """Contact by B-hat: what the finite elements of these tests find, with a compliance besides."""
    return with_ics(pressed()).sel(ics="Bhat")


@pytest.fixture
def fe_calls(monkeypatch, by_bhat):
    """Loads and cells for which finite elements were called."""
    calls = []

    def like_bhat(bodies, load, *, cells):
        calls.append((load, cells))
        assert all(body.domain == Domain(1280.0, 3 * 1280.0) for body in (bodies.lower, bodies.upper))
        case = by_bhat.isel(case=LOADS.index(load))
        a, b, p_max, approach = (float(case[name]) for name in ("a", "b", "p_max", "approach"))
        of_place = SIDEWAYS * load, 3 * SIDEWAYS * load, 0.2
        numbers = Numbers(a, b, np.radians(float(case.angle)), p_max, approach + RIGID * load, *of_place)
        x, s = np.meshgrid(np.linspace(0, a, 4), np.linspace(0, b, 5), indexing="ij")
        p = p_max * np.sqrt(np.maximum(1 - (x / a) ** 2 - (s / b) ** 2, 0))
        return FEContact(
            x=x.ravel(),
            s=s.ravel(),
            p=p.ravel(),
            s_range=(-b, b),
            numbers=numbers,
            estimate=Numbers(*(KNOWN * value for value in vars(numbers).values())),
            load=load,
            load_of_pressures=1.001 * load,
            reactions=(load, -load),
            tension=0.0,
            penetration=0.0,
            unknowns=(100, 200),
            steps=3,
            iterations=4,
            seconds={"patch": 1.0, "coarse": 2.0, "fine": 3.0},
            memory=1e3,
        )

    def rigid(jobs, _means, *, combined):
        assert combined
        assert all(job.grid.n_s == 1 for job in jobs.values())
        compliances = {name: np.zeros((4, 4)) for name in jobs}
        for name, m in compliances.items():
            m[FZ, FZ] = COMPLIANCE[name]
        return {name: SimpleNamespace(discount=m) for name, m in compliances.items()}

    monkeypatch.setattr(compute, "fe_contact", like_bhat)
    monkeypatch.setattr("femic.contact.finite_elements.meshed_contact.matrices", rigid)
    return calls


def test_numbers_by_finite_elements_join_numbers_with_ics(fe_calls, by_bhat):
    """Force, moment, centre and pressures along s at x = 0, too."""
    dataset = by_fe(pressed())
    assert list(dataset.ics.values) == ["A", "Bhat", FE]
    assert [load for load, _ in fe_calls] == LOADS
    for name in ("a", "b", "p_max", "angle"):
        np.testing.assert_allclose(dataset[name].sel(ics=FE), by_bhat[name])
        np.testing.assert_allclose(dataset[f"estimate_{name}"].sel(ics=FE), KNOWN * by_bhat[name])
    assert float(abs(dataset.p_max.sel(ics="A") / dataset.p_max.sel(ics=FE) - 1).max()) > 0.005
    np.testing.assert_allclose(dataset.F_y.sel(ics=FE), SIDEWAYS * np.array(LOADS))
    np.testing.assert_allclose(differences(dataset, "s_centre").sel(ics="A"), -0.2, atol=1e-6)
    np.testing.assert_allclose(estimates(dataset, "M_x"), KNOWN * 3 * SIDEWAYS * np.array(LOADS))
    s, p = dataset.s_fe[1].values, dataset.p_fe[1].values
    assert np.all(np.diff(s) > 0)
    assert len(s) == 5
    b, p_max = float(by_bhat.b[1]), float(by_bhat.p_max[1])
    np.testing.assert_allclose(p, p_max * np.sqrt(np.maximum(1 - (s / b) ** 2, 0)))


@pytest.mark.usefixtures("fe_calls")
@pytest.mark.parametrize(("discount", "rigid"), [("approach", RIGID), ("none", 0.0)])
def test_rigid_part_of_the_compliance_is_subtracted_from_approaches_unless_c_contains_it(
    discount, rigid, by_bhat
):
    """Nothing is fitted: other ICs beside finite elements do not change these."""
    dataset, whole = by_fe(replace(pressed(), discount=discount)), RIGID * np.array(LOADS)
    assert float(dataset.rigid_compliance) == pytest.approx(rigid)
    np.testing.assert_allclose(
        dataset.approach.sel(ics=FE), by_bhat.approach + whole - rigid * np.array(LOADS)
    )
    np.testing.assert_allclose(dataset.fe_raw_approach, by_bhat.approach + whole)
    np.testing.assert_array_equal(dataset.approach.sel(ics="Bhat"), by_bhat.approach)


@pytest.mark.usefixtures("fe_calls")
def test_supports_are_the_same_as_with_c(monkeypatch):
    monkeypatch.setattr(compute, "fe_contact", lambda bodies, *_, **__: pytest.fail(str(bodies.upper.domain)))
    with pytest.raises(pytest.fail.Exception, match=r"far_radius=90\.0, half_length=270\.0"):
        by_fe(replace(pressed(), support_radius=90.0))


def test_finished_loads_are_stored_by_load_cells_and_bodies(fe_calls, tmp_path):
    options = RunOptions(store=Store(tmp_path))
    first = by_fe(pressed(loads=LOADS[:2]), options)
    again = by_fe(pressed(), options, 15.0)
    assert [load for load, _ in fe_calls] == LOADS
    np.testing.assert_array_equal(first.a.sel(ics=FE), again.a.sel(ics=FE)[:2])
    by_fe(pressed(loads=LOADS[:1]), options, 20.0)
    assert fe_calls[3:] == [(LOADS[0], 20.0)]
    by_fe(scene(10.3, rolling_radius=401.0, loads=LOADS[:1], ics=["A"]), options)
    assert len(fe_calls) == 5


def test_loads_at_which_finite_elements_fail_are_left_out(fe_calls, monkeypatch):
    like_bhat = compute.fe_contact

    def failing(bodies, load, *, cells):
        if load == LOADS[1]:
            raise Failure("no mesh")
        return like_bhat(bodies, load, cells=cells)

    monkeypatch.setattr(compute, "fe_contact", failing)
    dataset = by_fe(pressed())
    assert dataset.attrs["left_out"] == "5000 N: no mesh"
    assert list(np.isnan(dataset.a.sel(ics=FE))) == [False, True, False]
    assert not np.any(np.isnan(dataset.a.sel(ics="A")))
    np.testing.assert_allclose(dataset.F_y.sel(ics=FE)[::2], SIDEWAYS * np.array(LOADS)[::2])
    assert "p_fe_1" not in dataset
    assert len(fe_calls) == 2
    with pytest.raises(Failure, match="5000 N: no mesh"):
        by_fe(pressed(loads=LOADS[1:2]))


def test_too_few_cells_are_refused_before_any_work(fe_calls, by_bhat):
    with pytest.raises(WrongInput, match=r"cells = 2\.0: at least"):
        compute_fe_contact(pressed(), by_bhat, cells=2.0)
    assert not fe_calls


def test_stored_loads_are_read_without_work(fe_calls, tmp_path):
    """The first two loads have been solved; the third has no numbers."""
    store = Store(tmp_path)
    first = by_fe(pressed(loads=LOADS[:2]), RunOptions(store=store))
    contacts = with_ics(pressed())
    stored = stored_fe_contact(pressed(), contacts, store)
    assert len(fe_calls) == 2
    np.testing.assert_array_equal(stored.a.sel(ics=FE)[:2], first.a.sel(ics=FE))
    assert np.isnan(stored.a.sel(ics=FE)[2])
    assert stored.attrs["left_out"] == "10000 N (not stored)"
    assert stored_fe_contact(pressed(), contacts, Store(tmp_path / "other")) is None
    assert stored_fe_contact(pressed(gap="exact"), contacts, store) is None
    assert float(stored.rigid_compliance) == pytest.approx(RIGID)


@pytest.mark.parametrize(
    ("keys", "message"),
    [
        ({"motion": "compression"}, r"contact\.motion = 'compression': .* leave it out"),
        ({"loads": [], "approaches": [0.1]}, r"contact\.loads = \[\]: .* give loads"),
        ({"gap": "exact"}, r"contact\.gap = 'exact': .* use the linear one"),
        ({"lateral_force": 100.0}, r"contact\.lateral_force: .* give the `shift`"),
    ],
)
def test_unsupported_scenes_are_refused_before_any_work(keys, message):
    with pytest.raises(BadScene, match=message):
        require_suitable(pressed(**keys))
    with pytest.raises(BadScene, match=r"discount = 'source': .* use 'approach'"):  # no bending of bodies
        require_suitable(replace(pressed(), discount="source"))


def test_page_of_contact_has_a_column_of_stored_finite_elements(fe_calls, tmp_path):
    """Its numbers, and a chart; nothing of that without them."""
    store = Store(tmp_path / "store")
    scene = pressed(loads=LOADS[:2])
    by_ics = compute_contact(scene)
    by_fe(pressed(loads=LOADS[:1]), RunOptions(store=store))
    beside = stored_solution(scene, by_ics, store)
    page = write_contact(scene, by_ics, tmp_path, beside).read_text(encoding="utf-8")
    assert page.count('<th scope="col">FE</th>') == 1
    assert "finite elements found no solution" in page.lower()
    assert 'id="chart-fe"' in page
    without = write_contact(scene, by_ics, tmp_path / "without").read_text(encoding="utf-8")
    assert '<th scope="col">FE</th>' not in without
    assert len(fe_calls) == 1
