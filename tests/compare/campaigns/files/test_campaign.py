"""Campaign files: axes, points, their order, and the scenes at points."""

import json
import tomllib

import numpy as np
import pytest

from compare.campaigns.campaign import find_points
from compare.campaigns.load import load_campaign
from compare.campaigns.plan import checked_points, require_computable
from femic.scenes.errors import BadScene
from femic.scenes.load import load_scene

GRID = """
scene = "geometry1"
[set]
bodies = ["combined"]
engine = { tolerance = 0.05 }
[sweep.flank]
keys = ["lower.contour.flank_inclination_deg", "upper.contour.flank_inclination_deg"]
from = 0
to = 60
count = 7
label = "flanks"
unit = "deg"
[sweep.ratio]
keys = { "upper.contour.radius" = 10, "upper.rolling_radius" = 400 }
values = [1.05, 1.2, 1.5]
"""
RANDOM = """
scene = "geometry1"
points = "random"
samples = %d
seed = %d
[sweep.E]
keys = ["lower.E"]
from = 1e3
to = 1e5
spacing = "logarithmic"
[sweep.nu]
keys = ["lower.nu", "upper.nu"]
from = 0.1
to = 0.4
"""
TABLE = """
scene = "geometry1"
points = "points.csv"
[sweep.E]
keys = ["upper.E"]
[sweep.kind]
keys = ["engine.kind"]
"""


@pytest.fixture
def campaign(tmp_path):
    """A function that loads a campaign from the text of its file, with some of it replaced."""

    def load(text, *replaced, name="mine"):
        for old, new in replaced:
            assert old in text
            text = text.replace(old, new)
        path = tmp_path / f"{name}.toml"
        path.write_text(text, encoding="utf-8")
        return load_campaign(path)

    return load


# --- grids -------------------------------------------------------------------------------------------


def test_a_grid_has_all_combinations_of_values(campaign):
    grid = campaign(GRID)
    assert grid.is_grid
    assert grid.shape == (7, 3)
    assert grid.size == 21
    assert {grid.point(number) for number in range(21)} == {
        (flank, ratio) for flank in (0, 10, 20, 30, 40, 50, 60) for ratio in (1.05, 1.2, 1.5)
    }
    assert grid.point(4) == (10, 1.2)  # C order
    assert [(axis.label, axis.unit) for axis in grid.axes] == [("flanks", "deg"), ("ratio", "")]
    assert grid.point_name((10.0, 1.2)) == "flank=10,ratio=1.2"
    assert grid.title == grid.name == "mine"


def test_values_of_ranges_are_rounded_and_logarithmic_ones_have_equal_ratios_and_exact_ends(campaign):
    """0.1 + 0.2 must not be another scene than 0.3."""
    assert campaign(GRID, ("to = 60", "to = 0.6")).axes[0].values == (0, 0.1, 0.2, 0.3, 0.4, 0.5, 0.6)
    changes = ("from = 0", "from = 0.7"), ('unit = "deg"', 'spacing = "logarithmic"')
    values = campaign(GRID, *changes).axes[0].values
    assert (values[0], values[-1]) == (0.7, 60)
    np.testing.assert_allclose(np.diff(np.log(values)), np.log(60 / 0.7) / 6, rtol=1e-10)


@pytest.mark.parametrize("count", [2, 3, 8, 33, 100])
def test_early_points_cover_the_range(campaign, count):
    """Of two axes ends and middles are first; after a share of one no gap is much wider than even ones."""
    first = [campaign(GRID).point(number) for number in campaign(GRID).order[:9]]
    assert {*first} == {(flank, ratio) for flank in (0, 30, 60) for ratio in (1.05, 1.2, 1.5)}
    grid = campaign(GRID, ("count = 7", f"count = {count}"), ("values = [1.05, 1.2, 1.5]", "values = [1.05]"))
    assert sorted(grid.order) == list(range(count))
    for share in (0.1, 0.3, 0.6):
        n = max(3, round(share * count))
        places = np.sort(grid.order[:n])
        assert np.max(np.diff(places)) <= max(1, 3 * count / n)


def test_scene_at_a_point_has_swept_and_common_keys(campaign):
    grid = campaign(GRID)
    scene = grid.scene((30.0, 1.2))
    same = {"kind": "arc", "flank_inclination_deg": 30.0}
    expected = load_scene(
        "geometry1",
        {
            "lower": {"contour": {"radius": 10.0, **same}},
            "upper": {"contour": {"radius": 12.0, **same}, "rolling_radius": 480.0},
            "bodies": ["combined"],
            "engine": {"tolerance": 0.05},
        },
    )
    assert repr(scene.bodies) == repr(expected.bodies)
    assert (scene.compared, scene.settings.tolerance) == (("combined",), 0.05)
    assert tomllib.loads(scene.text) == grid.scene_table((30.0, 1.2))
    before = json.dumps(grid.table)
    grid.scene_table((60, 1.5))["lower"]["E"] = 1
    assert json.dumps(grid.table) == before  # points do not share tables


def test_numbers_in_keys_are_places_in_lists(campaign):
    """Also of lists in lists: factors of friction by angle."""
    lines = 'lines = [{ along = "x", s = 0.0 }, { along = "x", s = 1.0 }]'
    of_ratio = 'keys = { "upper.contour.radius" = 10, "upper.rolling_radius" = 400 }'
    grid = campaign(GRID, ('bodies = ["combined"]', lines), (of_ratio, 'keys = ["lines.1.s"]'))
    assert [line.s[0] for line in grid.scene((0, 1.2)).lines] == [0.0, 1.2]
    grid = campaign(
        'scene = "rolling"\n[set.contact]\nfriction_by_angle = [[0, 1.0], [25, 0.5]]\n'
        '[sweep.flange]\nkeys = ["contact.friction_by_angle.1.1"]\nvalues = [0.3, 0.5]\n'
    )
    laws = [grid.scene((factor,)).contact.friction.friction_by_angle for factor in (0.3, 0.5)]
    assert laws == [((0.0, 1.0), (25.0, 0.3)), ((0.0, 1.0), (25.0, 0.5))]


def test_paths_are_relative_to_the_file_that_names_them(campaign, tmp_path):
    (tmp_path / "rail.txt").write_text("0 0\n1 0\n", encoding="utf-8")
    arc = 'contour = { kind = "arc", radius = 10.0, flank_inclination_deg = 25.5 }'
    base = load_scene("geometry1").text.replace(arc, 'contour = { kind = "points", file = "rail.txt" }', 1)
    (tmp_path / "base.toml").write_text(base, encoding="utf-8")
    grid = campaign('scene = "base.toml"\n[sweep.E]\nkeys = ["lower.E"]\nvalues = [1e5, 2e5]\n')
    assert grid.table["lower"]["contour"]["file"] == str(tmp_path / "rail.txt")
    (tmp_path / "g.txt").write_text("0 0 0\n1 0 0\n0 1 0\n", encoding="utf-8")
    swept = campaign(GRID + '[sweep.gap]\nkeys = ["contact.extra_gap"]\nvalues = ["g.txt"]\n')
    assert swept.scene_table((30, 1.2, "g.txt"))["contact"]["extra_gap"] == str(tmp_path / "g.txt")


# --- points that are not a grid ----------------------------------------------------------------------


def test_random_points_cover_the_ranges_and_more_of_them_contain_fewer(campaign):
    few, many = (campaign(RANDOM % (n, 1)) for n in (5, 64))
    assert not many.is_grid
    assert many.shape == (64,)
    assert many.listed[:5] == few.listed != campaign(RANDOM % (5, 2)).listed
    assert list(many.order) == list(range(64))
    e, nu = np.array(many.listed).T
    for shares in (np.log(e / 1e3) / np.log(100), (nu - 0.1) / 0.3):
        assert np.all((shares >= 0) & (shares <= 1))
        assert np.all(np.histogram(shares, 16, (0, 1))[0] == 4)  # Sobol points are that even


def test_a_table_has_points_of_any_kind(campaign, tmp_path):
    (tmp_path / "points.csv").write_text("kind, E, note\nharmonic, 1e5, a\nsolid, 2e5, b\n", encoding="utf-8")
    table = campaign(TABLE)
    assert table.listed == ((1e5, "harmonic"), (2e5, "solid"))
    assert table.scene(table.point(1)).settings.engine.name == "solid"


# --- points that are tried before the run ------------------------------------------------------------


def test_values_of_a_grid_are_checked_with_first_values_of_other_axes_long_axes_coarsely(campaign):
    grid = campaign(GRID)
    flanks, ratios = (axis.values for axis in grid.axes)
    assert {*checked_points(grid)} == {(flank, 1.05) for flank in flanks} | {(0, ratio) for ratio in ratios}
    points = list(checked_points(campaign(GRID, ("count = 7", "count = 20000"))))
    assert len(points) == 1000
    assert {ratio for _, ratio in points} == {1.05, 1.2, 1.5}
    assert np.max(np.diff(np.sort([flank for flank, _ in points]))) < 60 / 400


def test_rows_of_a_table_are_checked_and_extreme_ones_of_a_long_table(campaign, tmp_path):
    rows = [[f"{1e5 + k}", "harmonic"] for k in range(3001)]
    rows[1234][0], rows[1235][0], rows[1236][1] = "1", "1e9", "solid"
    for count in (900, 3001):
        text = "E,kind\n" + "\n".join(map(",".join, rows[:count]))
        (tmp_path / "points.csv").write_text(text, encoding="utf-8")
        table = campaign(TABLE)
        tried = list(checked_points(table))
        assert {*tried} <= {*table.listed}
        if count == 900:
            assert {*tried} == {*table.listed}
        else:
            assert {*table.listed[1234:1237]} <= {*tried}
            assert len(tried) <= 1000


def test_ends_of_random_points_are_checked(campaign):
    made = campaign(RANDOM % (100, 1))
    (e, nu), (all_e, all_nu) = made.listed[0], zip(*made.listed, strict=True)
    ends = {(min(all_e), nu), (max(all_e), nu), (e, min(all_nu)), (e, max(all_nu))}
    assert {*checked_points(made)} == ends


# --- what cannot be ----------------------------------------------------------------------------------

RATIOS, RADIUS = "1.05, 1.2, 1.5", '"upper.contour.radius" = 10'
WRONG = [
    (GRID, ("upper.rolling_radius", "upper.roling_radius"), "roling_radius"),
    (GRID, ("geometry1", "geometri1"), "did you mean 'geometry1'"),
    (GRID, ("lower.contour.fl", "middle.contour.fl"), "middle"),
    (GRID, ("lower.contour.fl", "lower.E.fl"), r"lower\.E\.fl.*E is a value, not a table"),
    (GRID, ("lower.contour.flank_inclination_deg", "lines.2.s"), "lines"),  # no such number in the list
    (GRID, ("to = 60", "to = 95"), "flank=95,ratio=1.05"),
    (GRID, ("to = 60", "to = -1"), "from = 0 is not below to = -1"),
    (GRID, ("count = 7", 'count = 7\nspacing = "logarithmic"'), "must be positive"),
    (GRID, ("count = 7", ""), "give count"),
    (GRID, ("count = 7", "count = 7\nvalues = [1]"), "either values, or both from and to"),
    (GRID, (f"values = [{RATIOS}]", ""), "either values, or both from and to"),
    (GRID, (RATIOS, "1.2, 1.2"), "one is given twice"),
    (GRID, (RATIOS, "1, 1.0000000000001"), "one is given twice"),  # to 12 digits
    (GRID, (RATIOS, "0.0, -0.0"), "one is given twice"),
    (GRID, ("1.2, 1.5", "1e300, 1.5"), "not a number, or larger than 1e"),
    (GRID, ("1.2, 1.5", f"1{'0' * 400}, 1.5"), "not a number, or larger than 1e"),
    (GRID, ("1.2, 1.5", "nan, 1.5"), "values: not a number"),
    (GRID, (RADIUS, '"upper.contour.radius" = 0'), "a factor is 0"),
    (GRID, (RADIUS, '"upper.E" = inf'), "a factor is 0, not a number"),
    (GRID, (RATIOS, "1e25"), (RADIUS, RADIUS.replace("10", "1e25")), r"upper\.contour\.radius = 1e\+50"),
    (GRID, ("from = 0\n", "from = 59.9999999999999\n"), "no number of 12"),
    (GRID, ("from = 0\nto = 60", "from = -1e308\nto = 1e308"), "no number of 12"),
    (GRID, ("from = 0\n", "from = 59.999999999\n"), ("count = 7", "count = 70"), "values are the same"),
    (GRID, ('"upper.rolling_radius" = 400', '"lower.contour" = 1'), "a key can belong to one axis only"),
    (
        GRID,
        ("count = 7", "count = 100000"),
        (f"values = [{RATIOS}]", "from = 1.1\nto = 1.5\ncount = 100000"),
        r"1e\+10 scenes over 2 axes; at most 1e\+07",
    ),
    (GRID, (RATIOS, '"a"'), "factors need values that are numbers"),
    (GRID, ("sweep.ratio", 'sweep."a b"'), "letters, digits and _ only"),
    (GRID, ("[set]", "keep = 3\n[set]"), "keep"),
    (RANDOM % (9, 1), ("from = 0.1\nto = 0.4", "values = [0.1, 0.2]"), "need from and to"),
    (TABLE, ("points.csv", "nowhere.csv"), "nowhere.csv"),
]


@pytest.mark.parametrize("case", WRONG, ids=[case[-1] for case in WRONG])
def test_wrong_campaign_is_refused_with_its_reason(campaign, case):
    text, *changes, message = case
    with pytest.raises(BadScene, match=message):
        require_computable(campaign(text, *changes))


def test_missing_file_is_reported(tmp_path):
    with pytest.raises(BadScene, match="no such file"):
        load_campaign(tmp_path / "none.toml")


# --- points by name ----------------------------------------------------------------------------------


def test_points_are_found_by_their_names_or_by_those_of_some_axes(campaign, tmp_path):
    grid = campaign(GRID)
    for number in range(grid.size):
        assert find_points(grid, grid.point_name(grid.point(number))) == [grid.point(number)]
    assert find_points(grid, "ratio=1.1,flank=33") == [(33, 1.1)]  # of any values
    assert find_points(grid, "flank=30") == [(30, 1.05), (30, 1.2), (30, 1.5)]
    assert find_points(grid, "ratio=1.2") == [(flank, 1.2) for flank in range(0, 61, 10)]
    (tmp_path / "points.csv").write_text("kind,E\nharmonic,1e5\nsolid,1e5\nsolid,2e5\n", encoding="utf-8")
    table = campaign(TABLE)
    assert find_points(table, "kind=solid") == [(1e5, "solid"), (2e5, "solid")]
    assert find_points(table, "E=1e5,kind=solid") == [(1e5, "solid")]
    assert find_points(table, "E=1e5, kind=[1, 2]") == [(1e5, [1, 2])]  # spaces and lists


def test_unknown_values_are_reported_with_the_known_ones(campaign):
    grid = campaign(GRID)
    with pytest.raises(BadScene, match=r"no points with ratio=1\.1; there are ratio: 1\.05, 1\.2, 1\.5"):
        find_points(grid, "ratio=1.1")
    with pytest.raises(BadScene, match=r"sweep\.ratio: 'abc': is not a number, and upper\.contour\.radius"):
        grid.scene_table((30, "abc"))


@pytest.mark.parametrize(
    "name", ["flank=30,ratio=1,x=2", "flank,ratio", "flank=1,flank=2,ratio=3", "", "x=3"]
)
def test_malformed_point_name_is_reported_with_its_usage(campaign, name):
    with pytest.raises(BadScene, match=r"give flank=\.\.\.,ratio=\.\.\., or some of them"):
        find_points(campaign(GRID), name)
