"""Transient rolling of a scene: arrays, file, sentences, figures; from the store and with other supports."""

import re

import numpy as np
import pytest
import xarray as xr

from compare.campaigns.kinds import CONTACT_NAMES
from compare.campaigns.kinds import contact as numbers_of
from compare.pages import transient as transient_page
from compare.pages.friction import number_tables, worst_friction
from compare.pages.transient import STEADY, TRANSIENT, parts, settling_distance
from femic.contact.motions.rolling import OF_ROLLING
from femic.reference.run_options import RunOptions
from femic.results.friction import compute_with_friction
from femic.scenes.errors import BadScene
from femic.scenes.listing import listing
from tests.compare.pages import read_number, require_number
from tests.femic.contact.wheel_on_rail import scene

KEYS = {"motion": "transient", "loads": [2e3], "friction": [0.2, 0.5], "creepage": 1e-3}


def rolling(**keys):
    return scene(13.0, **KEYS | keys)


@pytest.fixture(scope="module")
def dataset():
    return compute_with_friction(rolling(distance=16.0))


def test_arrays_have_estimates_at_all_distances_and_maps_at_the_last(dataset):
    assert dataset.F_x.dims == ("friction", "ics", "distance")
    assert dataset.distance.attrs["units"] == "mm"
    assert float(dataset.distance[0]) == 0.0
    for name in OF_ROLLING:
        assert np.all(dataset[f"estimate_{name}"] >= 0)
        assert dataset[f"estimate_steady_{name}"].dims == ("friction", "ics")
    area = float(dataset.attrs["dx"] * dataset.attrs["ds"])
    of_maps = dataset.p.sel(direction="x").sum(["x", "s"]) * area
    np.testing.assert_allclose(of_maps, dataset.F_x.isel(distance=-1), rtol=1e-9)
    assert dataset.attrs["creepage"] == 1e-3
    assert dataset.slip.attrs["units"] == "1"


@pytest.mark.slow  # tests/femic/contact/test_rolling.py has this on grids of its own
def test_transient_rolling_ends_at_steady_rolling_with_the_same_creepage(dataset):
    keys = {"motion": "rolling", "longitudinal": [-5e-3, 1e-3, 5e-3]}
    of = {"loads": KEYS["loads"], "friction": [0.5]}
    curve, dataset = compute_with_friction(scene(13.0, **of | keys)).sel(xi=1e-3), dataset.sel(friction=[0.5])
    for name in ("F_x", "p_max", "area", "dissipation"):
        np.testing.assert_allclose(dataset[f"steady_{name}"], curve[name], rtol=1e-4)
        np.testing.assert_allclose(dataset[name].isel(distance=-1), curve[name], rtol=1e-3)
    assert np.all(dataset.F_x.isel(distance=2) < 0.9 * curve.F_x)


def test_page_and_file_agree(dataset, tmp_path):
    page = TRANSIENT.write(dataset, tmp_path).read_text(encoding="utf-8")
    charts = {name.split("_0.")[0] for name in re.findall(r'id="chart-([^"]+)"', page)}
    assert charts == {"growth", "stick", "work", "numbers"}
    assert parts(xr.open_dataset(tmp_path / "contact.nc")).summary in page.replace("&#39;", "'")


def test_tables_have_some_distances_and_steady_rolling(dataset):
    forces, others = (table.blocks for table in number_tables(dataset, STEADY)[:2])
    table = forces[1]
    assert table.caption == "friction 0.5: F_x [N]"
    distances = [row.name for row in table.rows]
    assert len(distances) == 20 + 1
    assert (distances[0], distances[-1]) == ("0 mm", "steady")
    rolling = dataset.sel(friction=0.5, ics="Bhat")
    for row, key in ((table.rows[-2], "F_x"), (table.rows[-1], "steady_F_x")):
        value, estimate = (np.ravel(rolling[name])[-1] for name in (key, f"estimate_{key}"))
        require_number(f"{row.cells[1].text} {row.cells[1].below}", value, estimate)
    assert len(others[0].rows) == 5 + 1


def test_the_page_says_whether_the_force_becomes_steady(dataset):
    one = dataset.isel(friction=0, ics=1)
    at = settling_distance(one)
    assert parts(dataset).doubts == []
    near = abs(one.F_x - one.steady_F_x) <= 0.05 * one.steady_F_x
    assert bool(near.sel(distance=slice(at, None)).all())
    assert not bool(near.sel(distance=slice(None, at - 1e-6))[-1])
    short = dataset.isel(distance=slice(3))
    assert np.isnan(settling_distance(short.isel(friction=0, ics=1)))
    assert (
        parts(short).doubts[0].startswith("Rolling has not become steady at the end, with friction 0.2 and")
    )
    assert np.isnan(settling_distance(one.assign(steady_F_x=np.nan)))


def test_the_answer_has_the_numbers_of_the_arrays(dataset):
    at = dataset.sel(friction=worst_friction(dataset))
    for row, name in zip(transient_page.answer(dataset).rows, ("Bhat", "A"), strict=True):
        rolling = at.sel(ics=name)
        _, force, steady, distance = (cell.text for cell in row.filled)
        for text, key in ((force, "F_x"), (steady, "steady_F_x")):
            require_number(text, *(np.ravel(rolling[name])[-1] for name in (key, f"estimate_{key}")))
        assert float(distance) == pytest.approx(settling_distance(rolling), rel=1e-2)
    away = (100 * (dataset.F_x.sel(ics="A") - dataset.F_x.sel(ics="Bhat")) / dataset.friction / 2e3).values
    judged = transient_page.answer(dataset).rows[1].filled[0].below
    shown, known = read_number(judged)
    assert np.any(np.isclose(shown, np.abs(away), atol=known / 2))


def test_small_forces_are_not_drawn_and_steady_forces_are_lines(dataset):
    force, away, sliding = transient_page.growth(dataset).steps["μ\u00a0=\u00a00.2"]  # no F_y
    aside = {"F_y": 0.5 * dataset.F_x, "estimate_F_y": dataset.estimate_F_x, "steady_F_y": dataset.steady_F_x}
    assert len(transient_page.growth(dataset.assign(aside)).cells) == 2 * 4
    limit, of_friction = 0.2 * dataset.attrs["load"], dataset.sel(friction=0.2)
    levels = {round(float(curve.y[0]), 9) for curve in force.curves if len(curve.y) == 2}
    assert levels == {round(float(level), 9) for level in [*of_friction.steady_F_x, limit]}
    for ics, symbol in (("A", "A"), ("Bhat", "B̂")):
        own = of_friction.sel(ics=ics)
        difference = 100 * (own.F_x - of_friction.F_x.sel(ics="Bhat")) / limit
        for panel, expected in ((force, own.F_x), (away, difference), (sliding, 100 * own.sliding_share)):
            (drawn,) = (curve for curve in panel.curves if curve.label == symbol and len(curve.y) > 2)
            np.testing.assert_allclose(drawn.y, expected)


def test_campaigns_store_numbers_by_distance():
    numbers = numbers_of(rolling(distance=2.0, friction=[0.5], ics=["A"]), RunOptions(1))
    assert {"F_x", "estimate_F_x", "distance", "sliding_share"} <= set(numbers.variables) <= CONTACT_NAMES
    assert numbers.F_x.dims == ("friction", "ics", "distance")


def test_keys_of_other_motions_are_refused():
    with pytest.raises(BadScene, match="equal_force is only of motion = 'rolling', not 'transient'"):
        rolling(equal_force=0.3)
    with pytest.raises(BadScene, match="distance is only of motion = 'transient', not 'rolling': leave"):
        scene(motion="rolling", loads=[1e3], distance=3.0)
    with pytest.raises(BadScene, match=r"motion = 'transient' takes one load"):
        rolling(loads=[1e3, 2e3])


def test_keys_are_listed():
    assert "creepage = 0.002" in listing("rolling")
    assert "transient rolling: rolled distance [mm]" in listing("rolling")
