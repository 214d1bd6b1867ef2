"""What supports do to a contact with friction: which contact is solved again, what the file and page say."""

from dataclasses import replace

import numpy as np
import pytest

from compare.contact.pair_on_grid import placed_on
from compare.friction import bodies, compression_page, rolling_page, supports
from compare.friction.compression import compute_compression
from compare.friction.operators import full_operator
from compare.friction.quantities import OF_PATCH, OF_ROLLING
from compare.friction.rolling import compute_rolling
from compare.friction.supports import with_supports
from femic.reference.run_options import RunOptions
from geometries.grids import Grid
from tests.compare.friction.scenes import scene
from tests.compare.friction.test_rolling import in_place_of_c as stand_in

ROLLING = {"motion": "rolling", "loads": [2e3], "longitudinal": [-2e-3, 1e-4, 2e-3]}
COMPRESSION = {"motion": "compression", "loads": [1e3, 2e3]}
MOTIONS = [(ROLLING, compute_rolling, OF_ROLLING), (COMPRESSION, compute_compression, OF_PATCH)]
KEYS = {"friction": [0.5, 0.2], "ics": ["A", "C"], "shift": 0.1}
SAME, SOFTER = "the same", "a fifth softer"


@pytest.fixture
def in_place_of_c(monkeypatch):
    """C is B-hat; that of other supports is the same, and a fifth more."""
    monkeypatch.setattr(bodies, "full_reference_ics", stand_in)

    def scaled(of, placed, factor, _):
        operator = stand_in(of, placed, None).operator
        return replace(operator, transformed=factor * operator.transformed)

    monkeypatch.setattr(supports, "full_operator", scaled)
    monkeypatch.setattr(supports, "other_supports", lambda *_: iter([(SAME, 1.0, ""), (SOFTER, 1.2, "")]))


@pytest.mark.usefixtures("in_place_of_c")
@pytest.mark.parametrize(("keys", "compute", "quantities"), MOTIONS, ids=["rolling", "compression"])
def test_the_contact_with_the_least_friction_is_solved_with_other_supports(keys, compute, quantities):
    """At the creepage nearest 0, or the last load: with the same supports it is the one of the arrays."""
    of = scene(13.0, **KEYS, **keys)
    dataset = with_supports(of, compute(of), RunOptions(1))
    place = {"xi": 1e-4} if "xi" in dataset.dims else {"load": 2e3}
    given = {"friction": 0.2} | place
    assert {dim: float(dataset[f"supported_{dim}"]) for dim in given} == given
    by_c = dataset.sel({"ics": "C", **given})
    for name in quantities:
        assert float(dataset[f"supported_{name}"].sel(supports=SAME)) == pytest.approx(float(by_c[name]))
    softer = float(dataset.supported_approach.sel(supports=SOFTER) / by_c.approach)
    assert 1.05 < softer < 1.2  # the patch grows, too


@pytest.mark.usefixtures("in_place_of_c")
@pytest.mark.parametrize(
    ("write", "motion"), [(rolling_page.write_rolling, 0), (compression_page.write_compression, 1)]
)
def test_the_page_says_what_changes_and_what_does_not(write, motion, tmp_path):
    keys, compute, _ = MOTIONS[motion]
    of = scene(13.0, **KEYS, **keys)
    page = write(with_supports(of, compute(of), RunOptions(1)), tmp_path).read_text(encoding="utf-8")
    assert "what other supports change: by C, friction 0.2, " + ("2000 N" if motion else "0.01 %") in page
    assert f'<td class="name">{SOFTER}</td>' in page


@pytest.mark.usefixtures("in_place_of_c")
@pytest.mark.parametrize("changes", [{"ics": ["A"]}, {"ics": ["A", "C"], "supports": False}])
def test_nothing_is_solved_where_there_is_no_c_or_the_scene_wants_none(changes):
    of = scene(13.0, **KEYS | {"friction": [0.2]} | changes, **COMPRESSION)
    dataset = compute_compression(of)
    assert with_supports(of, dataset, RunOptions(1)) is dataset


class Body:
    """A body whose raw C is 0, and which has no asymmetry: what is left of a pair is what is subtracted."""

    def __init__(self, approach):
        self.m_zz = approach

    def paired_column(self, _, variation):
        return np.full((3, 3, 4, 6), 0.1 if variation else 0.0)

    def approach(self, variation):
        return self.m_zz * (2.0 if variation else 1.0)


def test_c_with_other_supports_has_their_responses_and_their_approach():
    placed = placed_on(scene(13.0, loads=[1e3], shift=0.05), Grid(4, 6, 0.5, 0.9, -0.7))
    of = scene(13.0, **COMPRESSION)
    found, nearer = (
        full_operator(of, placed, {"lower": Body(3.0), "upper": Body(-2.5)}, name) for name in ("", "nearer")
    )
    ones = np.zeros((4, 6, 3))
    ones[..., 2] = 1.0
    weight = 4 * np.cos(placed.grid.strips / 10.0).sum() * placed.grid.area
    along_z = np.cos(placed.grid.strips / 10.0)
    np.testing.assert_allclose(found(ones)[0, :, 2], -0.5 * weight * along_z, rtol=1e-9)
    raw = 2 * 0.1 * 4 * 6 * placed.grid.area
    np.testing.assert_allclose(nearer(ones)[0, :, 2], raw - 1.0 * weight * along_z, rtol=1e-9)
