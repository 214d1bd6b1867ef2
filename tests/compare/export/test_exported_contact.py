"""A file for CONTACT has the ICs that contact uses, also beside the crown: both give the same contact."""

import numpy as np
import pytest

from compare.contact.compute import compute_contact
from compare.export.contact_file import read
from femic.cache.store import Store
from femic.cli.main import DONE, exit_code
from femic.contact.normal import NormalProblem, solve
from femic.contact.operators.dense import GridOperator
from femic.contact.pairs.pair_on_grid import pair_on_grid
from femic.reference.run_options import RunOptions
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


def by_file(path, folder, ics):
    """The contact with the ICs of a file, and its lateral force."""
    command = ["export", str(path), "--out", str(folder), "--store", str(folder / "store"), "--ics", ics]
    assert exit_code(command) == DONE
    scene = load_scene(str(path))
    file, grid = read(folder / f"contact_{ics}.txt"), scene.grid
    nn = np.empty((grid.n_x, grid.n_s, grid.n_s))
    for observed, loaded in np.ndindex(grid.n_s, grid.n_s):
        nn[:, observed, loaded] = file.values[loaded, observed - loaded + grid.n_s - 1, :, N, N]
    nn = (nn + np.swapaxes(nn, 1, 2)) / 2 / scene.pair.constants.G
    on_grid = pair_on_grid(scene.contact_problem, grid)
    operator = GridOperator.of(nn[..., None, None], (N,))
    problem = NormalProblem(grid, operator, on_grid.flat, on_grid.distance, on_grid.cosine)
    contact = solve(problem, load=LOAD)
    return contact, on_grid.resultant(contact.p[..., None] * [0.0, 0.0, 1.0]).force[1]


@pytest.mark.parametrize("ics", [pytest.param("C", marks=pytest.mark.slow), "Bhat"])
def test_contact_computed_from_file_agrees_with_program_beside_crown(ics, tmp_path):
    path = tmp_path / "shifted.toml"
    path.write_text(TEXT.replace("ICS", ics).replace("FLANK", "flank_inclination_deg = 40"), encoding="utf-8")
    results = compute_contact(load_scene(str(path)), RunOptions(2, Store(tmp_path / "store")))
    own = results.solved.contacts[results.solved.loadings[0], ics].contact
    contact, lateral = by_file(path, tmp_path, ics)
    np.testing.assert_allclose(contact.p, own.normal.p, atol=1e-5 * own.normal.p.max())
    assert contact.approach == pytest.approx(own.normal.approach, rel=1e-6)
    assert lateral == pytest.approx(own.lateral_force, rel=1e-5)
    assert lateral < -0.05 * LOAD
