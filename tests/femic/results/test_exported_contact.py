"""A file for CONTACT has the ICs that contact uses, also beside the crown: both give the same contact."""

import re

import numpy as np
import pytest

from femic.cache.store import Store
from femic.cli.main import DONE, exit_code
from femic.contact.normal import NormalProblem, solve
from femic.contact.operators.dense import GridOperator
from femic.reference.run_options import RunOptions
from femic.results.contact import solve_scene
from femic.results.contact_file import read
from femic.scenes.load import load_scene
from geometries.patches import N

LOAD, SHIFT = 1e3, 0.09
UPPER = '{ kind = "arc", radius = 10.9, flank_inclination_deg = 40 }'
TEXT = f"""
patch = {{ a = 0.25, b = 0.35 }}
lower = {{ E = 210e3, nu = 0.3, contour = {{ kind = "arc", radius = 10.0, flank_inclination_deg = 50 }} }}
upper = {{ E = 70e3, nu = 0.2, rolling_radius = 100, contour = {UPPER} }}
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


def own_and_by_file(path, folder, ics):
    """The contact of a scene, and that with the ICs of its file on the same grid and its lateral force."""
    results = solve_scene(load_scene(str(path)), RunOptions(2, Store(folder / "store")))
    own = results.contacts[results.loadings[0], ics].contact
    command = ["export", str(path), "--out", str(folder), "--store", str(folder / "store"), "--ics", ics]
    assert exit_code(command) == DONE
    on_grid, file = own.on_grid, read(folder / f"contact_{ics}.txt")
    grid = on_grid.grid
    nn = np.empty((grid.n_x, grid.n_s, grid.n_s))
    for observed, loaded in np.ndindex(grid.n_s, grid.n_s):
        nn[:, observed, loaded] = file.values[loaded, observed - loaded + grid.n_s - 1, :, N, N]
    nn = (nn + np.swapaxes(nn, 1, 2)) / 2 / load_scene(str(path)).pair.constants.G
    operator = GridOperator.from_ics(nn[..., None, None], (N,))
    problem = NormalProblem(grid, operator, on_grid.flat, on_grid.distance, on_grid.cosine)
    contact = solve(problem, load=LOAD)
    lateral = on_grid.resultant(contact.p[..., None] * [0.0, 0.0, 1.0]).force[1]
    np.testing.assert_allclose(contact.p, own.normal.p, atol=1e-5 * own.normal.p.max())
    assert lateral == pytest.approx(own.lateral_force, rel=1e-5)
    return own, (contact, lateral)


@pytest.mark.parametrize("ics", [pytest.param("C", marks=pytest.mark.slow), "Bhat"])
def test_contact_computed_from_file_agrees_with_program_beside_crown(ics, tmp_path):
    own, (contact, lateral) = own_and_by_file(shifted_scene(tmp_path, GIVEN, ics), tmp_path, ics)
    assert contact.approach == pytest.approx(own.normal.approach, rel=1e-6)
    assert lateral < -0.05 * LOAD


GIVEN = "grid = { n_x = 24, n_s = 14, s = -0.9 }"


def shifted_scene(folder, grid="", ics="Bhat"):
    """The scene of these tests, with another grid or that of its contact."""
    text = TEXT if grid == GIVEN else TEXT.replace(GIVEN, grid).replace('grid = "scene", ', "")
    path = folder / "own.toml"
    path.write_text(text.replace("ICS", ics), encoding="utf-8")
    return path


def test_the_grid_is_that_of_the_contact_and_the_distances_are_its_own(tmp_path, capsys):
    own, _ = own_and_by_file(shifted_scene(tmp_path), tmp_path, "Bhat")
    grid, approach, file = own.on_grid.grid, own.normal.approach, read(tmp_path / "contact_Bhat.txt")
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
    path = shifted_scene(tmp_path, GIVEN)
    assert exit_code(["export", str(path), "--out", str(tmp_path), "--ics", "mix"]) == DONE
    assert "mix: the scene has no effective properties, so xn is taken from A" in capsys.readouterr().out
    path.write_text(path.read_text() + FIT)
    assert exit_code(["export", str(path), "--out", str(tmp_path), "--ics", "mix"]) == DONE
    assert "no effective properties" not in capsys.readouterr().out
