"""A file for CONTACT has the ICs that contact uses, also beside the crown: both give the same contact."""

import re

import numpy as np
import pytest

from femic.cache.store import Store
from femic.cli.main import DONE, exit_code
from femic.contact.normal import NormalProblem, solve
from femic.contact.operators.dense import GridOperator
from femic.contact.pairs.pair_on_grid import pair_on_grid
from femic.reference.run_options import RunOptions
from femic.results.contact import solve_scene
from femic.results.contact_file import read
from femic.scenes.load import load_scene
from geometries.patches import N

LOAD, SHIFT = 1e3, 0.09
TEXT = f"""
patch = {{ a = 0.25, b = 0.35 }}
lower = {{ E = 210e3, nu = 0.3, contour = {{ kind = "arc", radius = 10.0, flank_inclination_deg = 50 }} }}
upper = {{ E = 70e3, nu = 0.2, rolling_radius = 100, contour = {{ kind = "arc", radius = 10.9, FLANK }} }}
grid = {{ n_x = 24, n_s = 14, s = -0.9 }}
contact = {{ loads = [{LOAD}], shift = {SHIFT}, grid = "scene", ics = ["ICS"], supports = false }}
engine = {{ tolerance = 0.1, far_radius = 200 }}
"""
FIT = """
[effective.combined.mismatch_k]
far = -0.268655
r_inf = 48.9246
m = 0.98781
n = 13.0978
"""


def by_file(path, folder, ics, grid=None):
    """The contact with the ICs of a file on a grid, the scene's unless it is given; its lateral force."""
    command = ["export", str(path), "--out", str(folder), "--store", str(folder / "store"), "--ics", ics]
    assert exit_code(command) == DONE
    scene = load_scene(str(path))
    file, grid = read(folder / f"contact_{ics}.txt"), grid or scene.grid
    nn = np.empty((grid.n_x, grid.n_s, grid.n_s))
    for observed, loaded in np.ndindex(grid.n_s, grid.n_s):
        nn[:, observed, loaded] = file.values[loaded, observed - loaded + grid.n_s - 1, :, N, N]
    nn = (nn + np.swapaxes(nn, 1, 2)) / 2 / scene.pair.constants.G
    on_grid = pair_on_grid(scene.contact_problem, grid)
    operator = GridOperator.from_ics(nn[..., None, None], (N,))
    problem = NormalProblem(grid, operator, on_grid.flat, on_grid.distance, on_grid.cosine)
    contact = solve(problem, load=LOAD)
    return contact, on_grid.resultant(contact.p[..., None] * [0.0, 0.0, 1.0]).force[1]


@pytest.mark.parametrize("ics", [pytest.param("C", marks=pytest.mark.slow), "Bhat"])
def test_contact_computed_from_file_agrees_with_program_beside_crown(ics, tmp_path):
    path = tmp_path / "shifted.toml"
    path.write_text(TEXT.replace("ICS", ics).replace("FLANK", "flank_inclination_deg = 40"), encoding="utf-8")
    results = solve_scene(load_scene(str(path)), RunOptions(2, Store(tmp_path / "store")))
    own = results.contacts[results.loadings[0], ics].contact
    contact, lateral = by_file(path, tmp_path, ics)
    np.testing.assert_allclose(contact.p, own.normal.p, atol=1e-5 * own.normal.p.max())
    assert contact.approach == pytest.approx(own.normal.approach, rel=1e-6)
    assert lateral == pytest.approx(own.lateral_force, rel=1e-5)
    assert lateral < -0.05 * LOAD


def shifted_scene(folder, grid=""):
    """The scene of these tests, with another grid or that of its contact."""
    given = "grid = { n_x = 24, n_s = 14, s = -0.9 }"
    assert given in TEXT
    text = TEXT.replace(given, grid).replace('grid = "scene", ', "").replace("ICS", "Bhat")
    path = folder / "own.toml"
    path.write_text(text.replace("FLANK", "flank_inclination_deg = 40"), encoding="utf-8")
    return path


def test_the_grid_is_that_of_the_contact_and_the_distances_are_its_own(tmp_path, capsys):
    path = shifted_scene(tmp_path)
    results = solve_scene(load_scene(str(path)), RunOptions(1, Store(tmp_path / "store")))
    own = results.contacts[results.loadings[0], "Bhat"].contact
    grid, approach = own.on_grid.grid, own.normal.approach
    contact, lateral = by_file(path, tmp_path, "Bhat", grid)
    np.testing.assert_allclose(contact.p, own.normal.p, atol=1e-5 * own.normal.p.max())
    assert lateral == pytest.approx(own.lateral_force, rel=1e-5)
    file = read(tmp_path / "contact_Bhat.txt")
    assert (file.n_x, file.n_s, file.dx, file.ds) == (grid.n_x, grid.n_s, grid.dx, grid.ds)
    listed = np.loadtxt(tmp_path / "contact_distances.txt").reshape(grid.n_s, grid.n_x).T
    expected = own.on_grid.distance - approach * own.on_grid.cosine
    np.testing.assert_allclose(listed, expected, rtol=0, atol=1e-6 * approach)
    assert np.min(listed) < -0.9 * approach
    output = " ".join(capsys.readouterr().out.split())
    assert "grid misses contact" not in output
    assert "the approach by B-hat at 1000 N" in output


def test_a_grid_that_misses_the_contact_is_said_with_the_place_of_both(tmp_path, capsys):
    """Contact is at about s = -0.9 mm."""
    path = shifted_scene(tmp_path, "grid = { n_x = 16, n_s = 6, dx = 0.2, ds = 0.2, s = 1.5 }")
    assert exit_code(["export", str(path), "--out", str(tmp_path), "--ics", "A"]) == DONE
    output = " ".join(capsys.readouterr().out.split())
    found = re.search(
        r"covers s = 0.9 \.\.\. 2.1 mm, .*contact at 1000 N is at s = (\S+) \.\.\. (\S+) mm", output
    )
    low, high = map(float, found.groups())
    assert low < -0.9 < high < 0.9
    assert output.index("misses contact") < output.index("writing")


def test_mix_without_a_fit_is_said(tmp_path, capsys):
    path = shifted_scene(tmp_path)
    assert exit_code(["export", str(path), "--out", str(tmp_path), "--ics", "mix"]) == DONE
    assert "mix: the scene has no effective properties, so xn is that of A" in capsys.readouterr().out
    path.write_text(path.read_text() + FIT)
    assert exit_code(["export", str(path), "--out", str(tmp_path), "--ics", "mix"]) == DONE
    assert "no effective properties" not in capsys.readouterr().out
