"""What supports do to a contact with friction: which contact is solved again, what the file and page say."""

import pytest

from compare.pages.friction import quantity_label, support_tables, vanishes
from compare.pages.friction_pages import PAGES
from femic.contact import motions
from femic.contact.motions.compression import OF_COMPRESSION
from femic.contact.motions.rolling import OF_ROLLING
from femic.reference.run_options import RunOptions
from femic.results.friction import compute_with_friction, with_supports
from tests.compare.friction.conftest import SAME, SOFTER
from tests.compare.friction.scenes import scene
from tests.compare.pages import read_texts

ROLLING = {"motion": "rolling", "loads": [2e3], "longitudinal": [1e-4, 2e-3], "ics": ["C"], "friction": [0.2]}
COMPRESSION = {"motion": "compression", "loads": [1e3, 2e3]}
KEYS = {"friction": [0.5, 0.2], "ics": ["A", "C"], "shift": 0.1}


@pytest.fixture(scope="module")
def supported(request, in_place_of_c):  # noqa: ARG001
    of = scene(13.0, **KEYS | request.param)
    return with_supports(of, compute_with_friction(of), RunOptions(1))


@pytest.mark.parametrize("supported", [ROLLING, COMPRESSION], ids=["rolling", "compression"], indirect=True)
def test_the_contact_with_the_least_friction_is_solved_with_other_supports(supported):
    """At the creepage nearest 0, or the last load: with the same supports it is the one of the arrays."""
    dataset, quantities = supported, OF_ROLLING if "xi" in supported.dims else OF_COMPRESSION
    place = {"xi": 1e-4} if "xi" in dataset.dims else {"load": 2e3}
    given = {"friction": 0.2} | place
    assert {dim: float(dataset[f"supported_{dim}"]) for dim in given} == given
    by_c = dataset.sel({"ics": "C", **given})
    for name in quantities:
        assert float(dataset[f"supported_{name}"].sel(supports=SAME)) == pytest.approx(float(by_c[name]))
    softer = float(dataset.supported_approach.sel(supports=SOFTER) / by_c.approach)
    assert 1.05 < softer < 1.2  # the patch grows, too


@pytest.mark.parametrize(
    "supported",
    [
        pytest.param(ROLLING, id="rolling", marks=pytest.mark.slow),
        pytest.param(COMPRESSION, id="compression"),
    ],
    indirect=True,
)
def test_page_has_a_table_of_changes_with_other_supports(supported, tmp_path):
    dataset = supported
    motion, place = ("rolling", "0.01%") if "xi" in dataset.dims else ("compression", "2000 N")
    page = PAGES[motion].write(dataset, tmp_path).read_text(encoding="utf-8")
    assert f'<th class="name">computed with C, friction 0.2, {place}</th>' in page
    assert f"<th>change with {SOFTER}</th>" in page
    (table,) = support_tables(dataset)
    rows = read_texts(table)
    numbers = [name for name in motions.MOTIONS[motion].quantities if not vanishes(dataset, name)]
    assert list(rows) == [quantity_label(dataset, name).title for name in numbers]
    of_same, of_softer = (float(dataset.supported_approach.sel(supports=name)) for name in (SAME, SOFTER))
    before, same, softer = rows["ζ [mm]"]
    assert float(before.split(" ± ")[0]) == pytest.approx(of_same, rel=1e-3)
    assert same == "0"
    assert float(softer) == pytest.approx(of_softer - of_same, rel=0.05)


@pytest.mark.usefixtures("in_place_of_c")
@pytest.mark.parametrize("changes", [{"ics": ["A"]}, {"ics": ["A", "C"], "supports": False}])
def test_other_supports_are_not_solved_without_c_or_if_the_scene_excludes_them(changes):
    of = scene(13.0, **KEYS | {"friction": [0.2]} | changes, **COMPRESSION)
    dataset = compute_with_friction(of)
    assert with_supports(of, dataset, RunOptions(1)) is dataset
