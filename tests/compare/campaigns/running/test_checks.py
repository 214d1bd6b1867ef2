"""Before any work: wrong values and names are reported; the keys of results."""

import pytest

from compare.campaigns.plan import require_computable
from compare.campaigns.tasks import campaign_tasks, scene_task
from femic.cache.store import Store
from femic.scenes.errors import BadScene
from tests.compare.campaigns.campaigns import CELLS_OF_PATCHES, CHEAP, LIGHT, OF_UPPER, campaign_in


@pytest.mark.parametrize("name", ["seconds", "variant", "digest", "sample"])
def test_an_axis_may_not_have_the_name_of_a_result(tmp_path, name):
    campaign = campaign_in(tmp_path, LIGHT.replace("[sweep.nu]", f"[sweep.{name}]"))
    with pytest.raises(BadScene, match=rf"sweep\.{name}: .*rename the axis"):
        require_computable(campaign)


@pytest.mark.parametrize("value", ["0.5", "'soft'", "-0.2", "1e29"])
def test_wrong_value_in_the_middle_of_an_axis_is_refused(tmp_path, value):
    middle = LIGHT.replace("0.1, 0.2, 0.3", f"0.1, {value}, 0.3")
    with pytest.raises(BadScene, match=r"(?s)mine: 1 error\(s\)\n  at E=1,nu=.*upper\.nu = "):
        require_computable(campaign_in(tmp_path, middle))
    require_computable(campaign_in(tmp_path, LIGHT))


def test_scene_without_loads_in_the_middle_of_an_axis_is_refused(tmp_path):
    loads = "[sweep.forces]\nkeys = ['contact.loads']\nvalues = [[1e3], [], [2e3]]\n"
    campaign = campaign_in(tmp_path, 'keep = ["contact"]\n' + OF_UPPER + loads)
    with pytest.raises(BadScene, match=r"at R=11,forces=\[\]: \[contact\]: give loads"):
        require_computable(campaign)


def test_impossible_combinations_are_reported_and_not_refused(tmp_path):
    campaign = campaign_in(tmp_path, CELLS_OF_PATCHES)
    (combination,) = require_computable(campaign)
    assert combination.startswith("at cell=0.2,b=0.1: ")
    assert "engine.smallest_cell = 0.2: at most 0.1" in combination
    assert not require_computable(campaign_in(tmp_path, OF_UPPER))


def test_unknown_kind_of_results_is_refused(tmp_path):
    with pytest.raises(
        BadScene, match=r"mine: unknown keep = 'everything': must be one of errors, ics, contact"
    ):
        require_computable(campaign_in(tmp_path, 'keep = ["everything"]\n' + LIGHT))


@pytest.mark.parametrize("points", ["", 'points = "random"\nsamples = 64\n'])
@pytest.mark.parametrize("end", ["first", "last"])
def test_a_value_is_refused_only_where_it_fits_to_no_values_of_other_axes(tmp_path, points, end):
    """Cells may not be larger than the patch: that of 0.2 fits to the larger patches only."""
    sizes = [0.1, 0.25] if end == "first" else [0.25, 0.1]
    cells = [0.2, 0.05] if end == "first" else [0.05, 0.2]
    values = "from = {}\nto = {}" if points else "values = [{}, {}]"
    if points:
        sizes, cells = sorted(sizes), sorted(cells)
    axes = [
        f"[sweep.{name}]\nkeys = [{key!r}]\n{values.format(*of_axis)}\n"
        for name, key, of_axis in (("cell", "engine.smallest_cell", cells), ("b", "patch.b", sizes))
    ]
    campaign = campaign_in(tmp_path, points + CHEAP + "".join(axes))
    (combination, *_) = require_computable(campaign)
    assert "engine.smallest_cell = " in combination
    for wrong in () if points else ("5.0", "-0.2"):
        with pytest.raises(BadScene, match="smallest_cell"):
            require_computable(campaign_in(tmp_path, CHEAP + axes[0].replace("0.2", wrong) + axes[1]))


def test_check_with_the_other_engine_is_left_out(tmp_path):
    campaign = campaign_in(tmp_path, OF_UPPER.replace("check = false", "check = true"))
    ((_, task), *_) = campaign_tasks(campaign, Store(tmp_path))
    assert campaign.scene(campaign.point(0)).check is not None
    assert task.scene.check is None


def test_keys_of_results_depend_on_table_kind_of_results_and_contents_of_files(tmp_path):
    store, file = Store(tmp_path / "store"), tmp_path / "file.txt"
    file.write_text("1 2\n", encoding="utf-8")
    table = {"lower": {"E": 1.0}, "upper": {"E": 1}}
    points = {"contour": {"kind": "points", "file": str(file)}}
    naming = [
        {"lower": points},
        {"upper": points},
        {"contact": {"extra_gap": str(file)}},
        {"contact": {"ics": ["A", f"map:{file}"]}},
    ]

    def key_of(table, kind="errors"):
        return scene_task(table, (kind,), store).keys[kind]

    keys = [key_of(table), key_of(table, "ics"), key_of(table | {"upper": {"E": 2}}), *map(key_of, naming)]
    assert len(set(keys)) == len(keys)
    assert [key_of(dict(table)), *map(key_of, naming)] == [keys[0], *keys[3:]]
    file.write_text("1 3\n", encoding="utf-8")
    assert not {*map(key_of, naming)} & {*keys}
