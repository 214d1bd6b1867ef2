"""Frontiers of contacts of scenes, as commands and scene files ask for them."""

import re

import numpy as np
import pytest
import xarray as xr

from compare.pages.frontier import write_frontier
from compare.studies.contact_advice import advise_contact
from compare.studies.contact_frontier import MAP_OF_C, compute_contact_frontier, contact_methods
from compare.studies.frontier import Question, advise
from femic.advice import expected
from femic.cache.store import Store
from femic.cli.main import DONE, WRONG_INPUT, exit_code
from femic.contact.operators.approximations import approximate_matrix
from femic.reference.run_options import RunOptions, Watch
from femic.scenes.errors import BadScene
from femic.scenes.load import load_scene
from geometries.errors import Failure
from geometries.patches import Grid, N
from tests.compare.frontier.scenes import flat_text, put, text
from tests.compare.pages import require_room

ROLLING = 'motion = "rolling"\nfriction = [0.3]\nlongitudinal = [-0.004, 0.0, 0.004]'


@pytest.fixture
def write(tmp_path):
    def written(content):
        path = tmp_path / "mine.toml"
        path.write_text(content, encoding="utf-8")
        return str(path)

    return written


def test_every_way_on_half_spaces_is_as_good_as_the_reference(write, tmp_path, monkeypatch):
    """A is exact there, and all others are A: what differs is the grid."""
    put(monkeypatch, "A")
    path = write(flat_text(tmp_path))
    dataset = compute_contact_frontier(path, options=RunOptions(1))
    assert dataset.attrs["best"] == "C 0.1, 16 elements"
    on_its_grid = dataset.sel(way=dataset.elements == 16)
    errors = on_its_grid.error.where(on_its_grid.way != dataset.attrs["best"], drop=True)
    assert set(errors.ics.values) == {"A", "B", "Bbar", "Bhat", "mix"}
    assert float(errors.max()) < 1e-6
    own = on_its_grid.bound.sel(way=dataset.attrs["best"])
    assert not dataset.judged.sel(number="angle").any()  # a plane turns by no angle
    known = dataset.judged.sum("case") > 0
    np.testing.assert_allclose((on_its_grid.bound - own).sel(number=known), 0.0, atol=1e-6)
    assert np.all(dataset.bound.sel(way="A, 8 elements", number="p_max") > own.sel(number="p_max"))


def test_frontier_page_of_a_wheel_on_a_rail(write, tmp_path, monkeypatch):
    put(monkeypatch, "Bhat")
    said = []
    options = RunOptions(1, watch=Watch(on_stage=said.append))
    dataset = compute_contact_frontier(write(text()), options=options)
    left = [
        float(re.search(r"about (\d+) s of (\d+) s that are left", one)[2]) for one in said if "  C " in one
    ]
    assert len(left) > 1
    assert left == sorted(left, reverse=True)
    assert "starts with the same cells as C 0.1, 8 elements" in dataset.attrs["skipped"]
    assert np.all(dataset.seconds > 0)
    # B-hat is C here, on the same grid; A is not
    p_max = dataset.error.sel(number="p_max", case=20000)
    assert p_max.sel(way="Bhat, 16 elements") < 1e-3
    assert p_max.sel(way="A, 16 elements") > 1e-2
    html = write_frontier(dataset, tmp_path).read_text(encoding="utf-8")
    assert "Which ICs does this contact need?" in html
    stored = xr.open_dataset(tmp_path / "contact_frontier.nc")
    xr.testing.assert_allclose(stored.bound, dataset.bound)


@pytest.mark.slow
def test_rolling_has_both_scales_of_forces(write, tmp_path, monkeypatch):
    """Of the force where it is known, and of friction times load also where it nearly vanishes."""
    put(monkeypatch, "Bhat")
    path = write(text(contact="loads = [2e4]", motion=ROLLING))
    dataset = compute_contact_frontier(path, ("F_x", "F_x/limit", "sliding_share"), RunOptions(1))
    force, limit = (dataset.error.sel(number=name) for name in ("F_x", "F_x/limit"))
    assert float(dataset.error.sel(way="Bhat, 16 elements").max()) < 1e-3
    one = {"way": "A, 16 elements"}
    assert force.sel(one).item() > 1e-3
    # without creepage F_x is too small for shares of itself, and there A is off most
    judged = (dataset.judged.sel(number=name).item() for name in ("F_x", "F_x/limit"))
    assert tuple(judged) == (2, 3)
    assert limit.sel(one).item() > force.sel(one).item()
    assert write_frontier(dataset, tmp_path).is_file()


def test_what_does_not_fit_the_budget_is_listed(write, monkeypatch):
    put(monkeypatch, "Bhat")
    with pytest.raises(Failure, match=r"no reference C within the budget of 1e-09 s .*A, 8 elements: about"):
        compute_contact_frontier(write(text()), options=RunOptions(1), budget=1e-9)


def test_grids_are_half_as_fine_and_twice_as_fine_within_their_limits(write):
    for given, tried in ((8, [8, 16]), (20, [10, 20, 40]), (40, [20, 40, 64]), (64, [32, 64])):
        scene = load_scene(write(text()), {"contact": {"elements": given}})
        assert list(dict.fromkeys(way.elements for way in contact_methods(scene))) == tried
    of_scene = load_scene(write(text()), {"contact": {"grid": "scene"}})
    names = {way.name for way in contact_methods(of_scene, 0.1)}
    assert names == {"A", "B", "Bbar", "Bhat", "mix", "C 0.1"}


@pytest.mark.parametrize(
    ("command", "message"),
    [
        (["advise", "--want", "F_x"], "want = 'F_x': not of contact.motion = 'none'"),
        (
            ["advise", "--want", "p_max", "--components", "nn"],
            "--want, --components: give either contact numbers or components",
        ),
        (["advise", "--want", "p_max", "--budget", "-1"], "--budget -1: must be positive"),
        (["contact"], "ics = 'auto': the cheapest for what. Give want = "),
    ],
)
def test_wrong_questions_are_refused_before_any_work(write, tmp_path, capsys, command, message):
    out, scene = tmp_path / "out", text('ics = "auto"') if command == ["contact"] else text()
    command.insert(1, write(scene))
    assert exit_code([*command, "--out", str(out)]) == WRONG_INPUT
    assert not out.exists()
    assert re.search(message, " ".join(capsys.readouterr().err.split()))


@pytest.mark.slow
def test_advise_and_frontier_of_a_contact(write, tmp_path, capsys, monkeypatch):
    put(monkeypatch, "Bhat")
    path, out = write(text()), str(tmp_path / "out")
    ask = ["advise", path, "--want", "p_max,b", "--tolerance", "0.2", "--out", out]
    assert exit_code([*ask, "--solve"]) == DONE
    printed = " ".join(capsys.readouterr().out.split())
    for part in (
        "Use contact.ics = [",
        "the error of p_max, b is at most",
        "relative to the number itself",
        "measured against C",
    ):
        assert part in printed
    assert exit_code(ask) == DONE  # by what is known, without C
    assert re.search(
        r"Expected error of p_max with .*, from the \d+ most similar of \d+ solved scenes: ",
        " ".join(capsys.readouterr().out.split()),
    )
    assert exit_code(["frontier", path, "--want", "p_max", "--out", out]) == DONE
    printed = " ".join(capsys.readouterr().out.split())
    assert "Cheapest ICs within the tolerance of 2 %: for p_max, " in printed
    assert (tmp_path / "out" / "contact_frontier.html").is_file()


@pytest.mark.slow
@pytest.mark.parametrize("known", [True, False])
def test_scene_takes_the_cheapest_ics_for_what_it_wants(write, tmp_path, capsys, monkeypatch, known):
    """By what is known of similar contacts, and by C where nothing is."""
    put(monkeypatch, "Bhat")
    if not known:
        monkeypatch.setattr(expected, "expect", lambda *_: None)
    path = write(text('ics = "auto"\nwant = ["p_max"]\nics_tolerance = 0.1'))
    out = tmp_path / "out"
    chosen, _ = advise_contact(path, Question(("p_max",), 0.1), RunOptions(1), expect=expected.expect)
    assert (chosen.way == "") == known
    assert exit_code(["contact", path, "--out", str(out)]) == DONE
    because = f"Use contact.ics = [{chosen.ics!r}]"
    assert because in " ".join(capsys.readouterr().out.split())
    dataset = xr.open_dataset(out / "contact.nc")
    assert list(dataset.ics.values) == [chosen.ics]
    assert because in dataset.attrs["choice"]
    accuracy = "the expected error of p_max is at most" if known else "the error of p_max is at most"
    assert accuracy in (out / "contact.html").read_text(encoding="utf-8")


class Expected:
    """What is expected without C: A to 30 %, B to 8 %, of p_max alone."""

    def high(self, ics, number):
        return {"A": 0.3, "B": 0.08}.get(ics, np.inf) if number == "p_max" else np.inf

    def describe(self, ics, number):
        return f"{number} with {ics}: as in others."


@pytest.mark.parametrize(("tolerance", "ics"), [(0.3, "B"), (0.29, "B"), (0.08, "B")])
def test_what_is_expected_may_decide_without_c(write, tolerance, ics):
    """The closest ICs, as all take milliseconds; the simplest that are good enough are named, too."""
    question = Question(("p_max",), tolerance)
    advice, frontier = advise_contact(write(text()), question, RunOptions(1), expect=lambda *_: Expected())
    assert frontier is None
    assert advice.changes == {"contact": {"ics": [ics]}}
    advised = advice.text
    assert "the expected error of p_max is at most 8.00%" in advised
    assert f"p_max with {ics}: as in others." in advised
    assert ("A is also accurate enough: expected error at most 30.0%." in advised) == (tolerance == 0.3)
    assert advised.endswith(
        "This is the error from the ICs only; `femic contact` estimates the error from the elements."
    )


@pytest.mark.parametrize(("wants", "tolerance"), [(("p_max",), 0.079), (("p_max", "b"), 0.3)])
def test_c_is_solved_where_what_is_expected_does_not_decide(write, monkeypatch, wants, tolerance):
    asked, said = [], []
    monkeypatch.setattr("compare.studies.contact_advice.advise", lambda *_: "with C")
    monkeypatch.setattr(
        "compare.studies.contact_advice.compute_contact_frontier", lambda *_, **__: asked.append(wants)
    )
    for expect in (lambda *_: Expected(), lambda *_: None):
        options = RunOptions(1, watch=Watch(on_stage=said.append))
        advice, _ = advise_contact(write(text()), Question(wants, tolerance), options, expect=expect)
        assert advice == "with C"
    assert asked == [wants, wants]
    assert said == ["similar contacts do not settle the question, so C is computed"] * 2


def test_advice_on_a_number_that_vanishes_is_refused_before_c(write, monkeypatch):
    """Both bodies are symmetric: nothing pushes them sideways."""
    monkeypatch.setattr("compare.studies.contact_frontier.first_models", lambda *_: pytest.fail("C"))
    scene = write(text(motion='motion = "compression"\nfriction = [0.3]'))
    with pytest.raises(Failure, match=r"F_y: it nowhere .* with any approximation, .*; want F_y/limit"):
        advise_contact(scene, Question(("p_max", "F_y"), 0.1), RunOptions(1))


@pytest.mark.parametrize(
    ("top", "contact", "message"),
    [
        ('want = ["p_max"]', "", "want = .*: the scene has no contact: give .contact. loads"),
        ('want = ["p_max", "p_max"]', "loads = [1e3]", "given twice"),
    ],
)
def test_scenes_that_want_what_their_contact_has_not_are_refused(write, top, contact, message):
    with pytest.raises(BadScene, match=message):
        load_scene(write(text(top, contact)))


@pytest.mark.slow
def test_c_on_a_finer_grid_is_the_reference(write, tmp_path, browser):
    """C itself: its own row has its estimate; at other tolerances it is within both estimates."""
    store = Store(tmp_path / "store")
    path = write(text(contact="loads = [2e4]"))
    dataset = compute_contact_frontier(path, options=RunOptions(2, store))
    best = dataset.sel(way=dataset.attrs["best"])
    assert best.elements == 16
    np.testing.assert_array_equal(best.error, best.bound)
    np.testing.assert_array_equal(best.error, best.estimate)
    other = dataset.sel(way="C 0.001, 8 elements")
    assert np.all(other.error <= other.estimate + best.estimate)
    assert np.all(dataset.ics_seconds.where(dataset.kind == "harmonic", drop=True) > 0)
    again = compute_contact_frontier(path, ("p_max",), RunOptions(2, store))
    assert again.ics_seconds.sel(way=dataset.attrs["best"]) == best.ics_seconds  # as they were stored
    require_room(browser, write_frontier(dataset, tmp_path), {800: 800})


OWN_GRID = {"n_x": 24, "n_s": 24, "dx": 0.5, "ds": 0.5}


class Map:
    """A map of C that is B-hat, a share larger, known to 1 %."""

    grid = Grid(*OWN_GRID.values(), 0.0)

    def __init__(self, share):
        self.share = share

    def at(self, on_grid):
        """C_nn on a grid, and its error."""
        ics = (1 + self.share) * approximate_matrix("Bhat", on_grid.pair, on_grid.grid)[..., N, N]
        return ics, 0.01 * ics


@pytest.mark.slow
def test_compression_has_errors_at_each_load(write, tmp_path, monkeypatch):
    """B-hat is C: no error of it exceeds what the tractions are solved to, and A has some."""
    put(monkeypatch, "Bhat")
    path = write(text(contact="loads = [1e4, 2e4]", motion='motion = "compression"\nfriction = [0.3]'))
    dataset = compute_contact_frontier(path, ("p_max", "sliding_share"), RunOptions(1))
    assert list(dataset.case.values) == [0.3]
    assert dataset.points.sel(number="p_max").item() == 2
    elements = dataset.sel(way=dataset.attrs["best"]).elements.item()
    assert float(dataset.error.sel(way=f"Bhat, {elements} elements").max()) < 2e-3
    assert dataset.error.sel(way=f"A, {elements} elements", number="p_max").item() > 5e-3
    assert write_frontier(dataset, tmp_path).is_file()


@pytest.mark.slow
def test_map_of_c_is_a_way_with_its_own_error(write, tmp_path, monkeypatch):
    """A map that is 3 % softer than C: pressures go like the modulus to 2/3, 2 % less."""
    put(monkeypatch, "Bhat")
    named = f"map:{tmp_path / 'sweep.nc'}"
    scene = text(contact=f'loads = [2e4]\ngrid = "scene"\nics = ["A", "{named}"]')
    table = "\n[grid]\n" + "\n".join(f"{key} = {value}" for key, value in OWN_GRID.items())
    path = write(scene.replace("elements = 8\n", "") + table)
    dataset = compute_contact_frontier(path, ("p_max",), RunOptions(1), {named: Map(0.03)})
    (name,) = dataset.way.values[dataset.kind.values == MAP_OF_C]
    assert name == named
    of_map = dataset.sel(way=name, number="p_max").squeeze()
    assert of_map.error.item() == pytest.approx(1 - 1.03 ** (-2 / 3), rel=0.1)
    assert np.isfinite(of_map.seconds)
    assert dataset.attrs["best"] != named
    advice = advise(dataset, Question(("p_max",), 0.1))
    assert advice.way in dataset.way.values
    assert write_frontier(dataset, tmp_path).is_file()
