"""Frontiers of contacts in static compression, and of a scene that names a map of C."""

import numpy as np
import pytest

from compare.pages.frontier import write_frontier
from compare.studies.contact_frontier import MAP_OF_C, compute_contact_frontier
from compare.studies.frontier import Question, advise
from femic.contact.operators.approximations import approximate_matrix
from femic.reference.run_options import RunOptions
from geometries.patches import Grid, N
from tests.compare.frontier.scenes import put, text

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
def test_compression_has_errors_at_each_load(tmp_path, monkeypatch):
    """B-hat is C: no error of it exceeds what the tractions are solved to, and A has some."""
    put(monkeypatch, "Bhat")
    path = tmp_path / "mine.toml"
    path.write_text(text(contact="loads = [1e4, 2e4]", motion='motion = "compression"\nfriction = [0.3]'))
    dataset = compute_contact_frontier(str(path), ("p_max", "sliding_share"), RunOptions(1))
    assert list(dataset.case.values) == [0.3]
    assert dataset.points.sel(number="p_max").item() == 2
    elements = dataset.sel(way=dataset.attrs["best"]).elements.item()
    assert float(dataset.error.sel(way=f"Bhat, {elements} elements").max()) < 2e-3
    assert dataset.error.sel(way=f"A, {elements} elements", number="p_max").item() > 5e-3
    assert write_frontier(dataset, tmp_path).is_file()


@pytest.mark.slow
def test_map_of_c_is_a_way_with_its_own_error(tmp_path, monkeypatch):
    """A map that is 3 % softer than C: pressures go like the modulus to 2/3, 2 % less."""
    put(monkeypatch, "Bhat")
    path, named = tmp_path / "mine.toml", f"map:{tmp_path / 'sweep.nc'}"
    scene = text(contact=f'loads = [2e4]\ngrid = "scene"\nics = ["A", "{named}"]')
    table = "\n[grid]\n" + "\n".join(f"{key} = {value}" for key, value in OWN_GRID.items())
    path.write_text(scene.replace("elements = 8\n", "") + table)
    dataset = compute_contact_frontier(str(path), ("p_max",), RunOptions(1), {named: Map(0.03)})
    (name,) = dataset.way.values[dataset.kind.values == MAP_OF_C]
    assert name == named
    of_map = dataset.sel(way=name, number="p_max").squeeze()
    assert of_map.error.item() == pytest.approx(1 - 1.03 ** (-2 / 3), rel=0.1)
    assert np.isfinite(of_map.seconds)
    assert dataset.attrs["best"] != named
    advice = advise(dataset, Question(("p_max",), 0.1))
    assert advice.way in dataset.way.values
    assert write_frontier(dataset, tmp_path).is_file()
