"""What supports do to a contact with friction: which contact is solved again, what the file and page say."""

import pytest

from compare.friction.compute import compute_with_friction
from compare.friction.pages import PAGES
from compare.friction.supports import with_supports
from femic.contact.pairs.quantities import OF_COMPRESSION, OF_ROLLING
from femic.reference.run_options import RunOptions
from tests.compare.friction.conftest import SAME, SOFTER
from tests.compare.friction.scenes import scene

ROLLING = {"motion": "rolling", "loads": [2e3], "longitudinal": [-2e-3, 1e-4, 2e-3]}
COMPRESSION = {"motion": "compression", "loads": [1e3, 2e3]}
MOTIONS = [(ROLLING, OF_ROLLING), (COMPRESSION, OF_COMPRESSION)]
KEYS = {"friction": [0.5, 0.2], "ics": ["A", "C"], "shift": 0.1}


@pytest.mark.usefixtures("in_place_of_c")
@pytest.mark.parametrize(("keys", "quantities"), MOTIONS, ids=["rolling", "compression"])
def test_the_contact_with_the_least_friction_is_solved_with_other_supports(keys, quantities):
    """At the creepage nearest 0, or the last load: with the same supports it is the one of the arrays."""
    of = scene(13.0, **KEYS, **keys)
    dataset = with_supports(of, compute_with_friction(of), RunOptions(1))
    place = {"xi": 1e-4} if "xi" in dataset.dims else {"load": 2e3}
    given = {"friction": 0.2} | place
    assert {dim: float(dataset[f"supported_{dim}"]) for dim in given} == given
    by_c = dataset.sel({"ics": "C", **given})
    for name in quantities:
        assert float(dataset[f"supported_{name}"].sel(supports=SAME)) == pytest.approx(float(by_c[name]))
    softer = float(dataset.supported_approach.sel(supports=SOFTER) / by_c.approach)
    assert 1.05 < softer < 1.2  # the patch grows, too


@pytest.mark.usefixtures("in_place_of_c")
@pytest.mark.parametrize(("keys", "place"), [(ROLLING, "0.01 %"), (COMPRESSION, "2000 N")])
def test_page_has_a_table_of_changes_with_other_supports(keys, place, tmp_path):
    of = scene(13.0, **KEYS, **keys)
    dataset = with_supports(of, compute_with_friction(of), RunOptions(1))
    page = PAGES[keys["motion"]].write(dataset, tmp_path).read_text(encoding="utf-8")
    assert "changes with other supports, computed with C, friction 0.2, " + place in page
    assert f'<th class="name">{SOFTER}</th>' in page


@pytest.mark.usefixtures("in_place_of_c")
@pytest.mark.parametrize("changes", [{"ics": ["A"]}, {"ics": ["A", "C"], "supports": False}])
def test_other_supports_are_not_solved_without_c_or_if_the_scene_excludes_them(changes):
    of = scene(13.0, **KEYS | {"friction": [0.2]} | changes, **COMPRESSION)
    dataset = compute_with_friction(of)
    assert with_supports(of, dataset, RunOptions(1)) is dataset
