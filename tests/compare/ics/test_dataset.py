"""Labelled results: sums over the bodies, errors recomputed by hand, files."""

import numpy as np
import pytest

from approx.halfspace import HalfSpace
from femic.reference.discount import rigid_part
from femic.results import ics_dataset as data
from geometries.materials import both_bodies
from geometries.patches import Load
from tests.compare.conftest import on_line


def test_combined_ics_are_sum_of_bodies_and_a_that_with_combined_constants(small):
    results, dataset, _ = small
    total = dataset.ic.sel(body="upper") + dataset.ic.sel(body="lower")
    np.testing.assert_allclose(dataset.ic.sel(body="combined"), total, rtol=1e-14)
    scene = results.scene
    constants = both_bodies(scene.bodies["upper"].material, scene.bodies["lower"].material)
    a = HalfSpace(constants).ics(scene.patch, dataset.x.values, dataset.s.values) / scene.patch.area
    computed = dataset.ic.sel(variant="A", body="combined").values
    np.testing.assert_allclose(computed, a, rtol=1e-11, atol=1e-13 * np.abs(a).max())


def far_away(dataset):
    """Points four elements (0.6 x 0.4 mm) from the load and further."""
    elements = np.hypot(dataset.x / 0.6, dataset.s / 0.4)
    return dataset.isel(point=np.flatnonzero(elements >= 4 - 1e-9))


def test_errors_follow_definition(small):
    _, dataset, errors = small
    line = on_line(dataset, "s = 1.6 mm").sel(body="upper")
    c, b = (line.ic.sel(variant=v, i="x", j="n").values for v in ("C", "Bhat"))
    c_nn = line.ic.sel(variant="C", i="n", j="n").values
    everywhere = far_away(dataset).ic.sel(variant="C", body="upper", i="x", j="n").values
    at = errors.sel(variant="Bhat", body="upper", line="s = 1.6 mm", i="x", j="n")
    assert at.error.item() == pytest.approx(np.abs(b - c).max() / np.abs(everywhere).max())
    assert at.rms.item() == pytest.approx(np.sqrt(np.mean((b - c) ** 2)) / np.abs(everywhere).max())
    assert at.weight.item() == pytest.approx(np.abs(b - c).max() / np.abs(c_nn).max())
    assert not at.vanishes


def test_estimate_of_c_is_given_on_both_scales(small):
    _, dataset, errors = small
    line = on_line(dataset, "s = 1.6 mm").sel(body="combined", i="x", j="n")
    c, nn = (on_line(dataset, "s = 1.6 mm").ic.sel(variant="C", body="combined", i=i, j="n") for i in "xn")
    at = errors.sel(variant="C", body="combined", line="s = 1.6 mm", i="x", j="n")
    known = line.estimate.max().item()
    everywhere = far_away(dataset).ic.sel(variant="C", body="combined", i="x", j="n")
    assert at.error.item() == pytest.approx(known / abs(everywhere).max().item())
    floor = 0.05 * abs(nn).max().item()
    assert at.estimate_refinement.item() == pytest.approx(known / max(abs(c).max().item(), floor))
    assert at.weight.item() == pytest.approx(known / abs(nn).max().item())


def test_raw_and_discount_give_c(small):
    results, dataset, _ = small
    for name in ("lower", "upper"):
        m = dataset.discount.sel(solved=name).values
        loads = [Load(results.scene.patch, j) for j in range(3)]
        rigid = [rigid_part(m, results.scene.bodies[name], results.points, load) for load in loads]
        c = dataset.raw.sel(solved=name).values - np.swapaxes(rigid, 0, 1)
        np.testing.assert_allclose(dataset.ic.sel(variant="C", body=name), c, rtol=1e-12, atol=1e-20)


def test_csv_contains_curves_under_their_names(small, tmp_path):
    results, dataset, _ = small
    data.write_curves(dataset, results.scene.components, tmp_path)
    table = np.genfromtxt(tmp_path / "curves_x1.6mm.csv", delimiter=",", names=True, deletechars="")
    line = on_line(dataset, "x = 1.6 mm")
    np.testing.assert_allclose(table["s_[mm]"], line.s, rtol=1e-9)
    b_sn = line.ic.sel(variant="B", body="lower", i="s", j="n")
    np.testing.assert_allclose(table["B_sn_lower_[mm/N]"], b_sn, rtol=1e-9, atol=1e-25)
