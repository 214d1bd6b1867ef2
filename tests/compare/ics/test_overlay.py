"""Overlays of scenes: curves and errors as in the files, what is computed when, messages."""

import csv
import json
import re
import shutil

import numpy as np
import pytest
import xarray as xr

from compare.pages.ics import page
from compare.pages.ics_figures import DASHES, along_line, chart, drawn_variants, is_mirrored
from compare.pages.ics_results import MOST_SCENES, differences, load, sources
from compare.report.looks import OWN, ics_symbol
from compare.report.tables import with_estimate
from femic.cache.folders import LOCK
from femic.cli.main import DONE, INTERRUPTED, WRONG_INPUT, exit_code
from tests.compare.conftest import on_line, scene_text
from tests.compare.pages import read_chart, read_traces, without_pictures

ALONG_S = '\n[[lines]]\nalong = "s"\nx = 1.6\nreach = 8.0\npoints = 33\n'
ALONG_X = '\n[[lines]]\nalong = "x"\ns = 0.0\nreach = 8.0\npoints = 33\n'
GENTLE = 'bodies = ["lower"]\ncomponents = ["nn", "sn", "xn"]\nvariants = ["A", "B", "Bbar", "Bhat"]'
STEEP = (
    'bodies = ["lower"]\ncomponents = ["sn", "nn"]\nvariants = ["Bhat", "A", "Bbar"]\nreference_length = 4.0'
)
LINE = "x = 1.6 mm"  # the one that both have
SCENES = ("gentle.toml", "steep.toml")


@pytest.fixture(scope="module", autouse=True)
def _bare():
    """What pages of single scenes show does not matter here."""
    with without_pictures():
        yield


@pytest.fixture(scope="module")
def compared(tmp_path_factory):
    """Two scene files and results/ of their comparison; nobody changes this folder."""
    folder = tmp_path_factory.mktemp("overlay")
    steep = scene_text(STEEP, flanks="50.0", lines=ALONG_S).replace("E = 210000.0", "E = 70e3", 1)
    (folder / "gentle.toml").write_text(scene_text(GENTLE, flanks="20.0"), encoding="utf-8")
    (folder / "steep.toml").write_text(steep, encoding="utf-8")
    assert compare(folder, *SCENES) == DONE
    return folder


@pytest.fixture
def copied(compared, tmp_path):
    """A copy of the scenes and their results."""
    return shutil.copytree(
        compared, tmp_path / "copy", ignore=shutil.ignore_patterns("gentle_steep", "figures")
    )


@pytest.fixture
def computed(monkeypatch):
    """Names of the scenes whose computation starts; it is interrupted at once."""
    names = []

    def run_scene(scene, *_, **__):
        names.append(scene.name)
        raise KeyboardInterrupt

    monkeypatch.setattr("compare.pages.ics_results.run_scene", run_scene)
    return names


def compare(folder, *scenes, out=None):
    where = ["--results", str(folder / "results"), *(["--out", str(out)] if out else [])]
    return exit_code(["compare", *(str(folder / scene) for scene in scenes), *where, "--workers", "1"])


@pytest.fixture(scope="module")
def overlay(compared):
    """The scenes and their results, as they are compared."""
    return load(sources([str(compared / scene) for scene in SCENES], compared / "results"))


def ics_of(overlay):
    return {name: scene.ics for name, scene in overlay.items()}


def cells_of(overlay, component):
    """The cells of a component as the page has them, by title."""
    content = read_chart(chart(ics_of(overlay)))
    assert content["labels"][content["start"]] == "nn"
    return {cell["title"]: cell for cell in content["steps"][content["labels"].index(component)]}


def read(folder, name):
    return xr.load_dataset(folder / "results" / name, engine="h5netcdf")


def test_overlay_writes_report_and_csv(compared):
    out = compared / "results" / "gentle_steep"
    assert {path.name for path in out.iterdir()} - {LOCK} == {"report.html", "curves_x1.6mm.csv"}
    html = (out / "report.html").read_text(encoding="utf-8")
    assert html.count('class="chart"') == html.count('id="chart-curves"') == 1
    assert "http" not in html  # self-contained
    assert str(compared) not in html


@pytest.mark.parametrize(("name", "E", "L"), [("gentle", 210e3, 10.0), ("steep", 70e3, 4.0)])
def test_curves_agree_with_ics_file_in_unit_of_scene(name, E, L, compared, overlay):
    curves = dimensionless(overlay[name].ics, "sn")
    line = on_line(read(compared, f"{name}/ics.nc"), LINE).sel(body="lower", i="s", j="n")
    assert curves.across == "s / L  [-]"
    np.testing.assert_allclose(curves["at"], line.s / L, rtol=1e-13)
    np.testing.assert_allclose(curves.estimate, line.estimate * E * L, rtol=1e-13)
    expected = line.ic.sel(variant=curves.variant) * E * L
    np.testing.assert_allclose(curves.ic, expected, rtol=1e-13)


def dimensionless(ics, component):
    return along_line(ics, LINE, "lower", component, dimensionless=True)


def test_chart_has_curves_of_all_scenes_and_their_differences(overlay):
    assert drawn_variants(overlay["gentle"].ics, several=True) == ["A", "Bhat", "C"]
    cells = cells_of(overlay, "sn")
    assert list(cells) == [f"lower, {LINE}", f"lower, {LINE}: minus C"]
    dashes = set()
    for title, cell in cells.items():
        drawn = read_traces(cell)
        ordinates = [y for curve in drawn.values() for y in curve["y"]]
        seen = 2e-3 * (max(ordinates) - min(ordinates))
        for name, scene in overlay.items():
            expected = dimensionless(scene.ics, "sn")
            expected = expected.isel(point=expected["at"].values >= 0)
            for variant in ("C", "A", "Bhat"):
                curve = drawn.pop(f"{ics_symbol(variant)}, {name}")
                c = expected.ic.sel(variant="C") if "minus" in title else 0.0
                between = np.interp(expected["at"], curve["x"], curve["y"])
                values = expected.ic.sel(variant=variant) - c
                np.testing.assert_allclose(between, values, atol=seen)
                assert curve["line"]["color"] == OWN[variant].colour
                dashes.add((name, curve["line"]["dash"]))
        assert not drawn
    assert dashes == {("gentle", "solid"), ("steep", "dash")}
    assert len(set(DASHES)) == MOST_SCENES


def test_both_halves_of_line_are_shown_if_a_scene_is_not_symmetric(overlay):
    steep = overlay["steep"].ics
    assert is_mirrored(steep, LINE)
    tilted = steep.assign(ic=steep.ic.where(steep.s > 0, 1.01 * steep.ic))
    assert not is_mirrored(tilted, LINE)
    tilted_overlay = overlay | {"steep": overlay["steep"]._replace(ics=tilted)}
    cell = cells_of(tilted_overlay, "nn")[f"lower, {LINE}"]
    gentle = next(trace for trace in cell["traces"] if trace.get("name") == "C, gentle")
    assert min(gentle["x"]) == -6.0 / 10.0


def test_csv_contains_curves(compared, overlay):
    path = compared / "results" / "gentle_steep" / "curves_x1.6mm.csv"
    with path.open(encoding="utf-8", newline="") as file:
        rows = [row for row in csv.DictReader(file) if (row["scene"], row["component"]) == ("steep", "sn")]
    steep = dimensionless(overlay["steep"].ics, "sn")
    a, c = (steep.ic.sel(variant=variant) for variant in "AC")
    expected = {"s/L": steep["at"], "A": a, "C": c, "estimate": steep.estimate}
    for column, values in expected.items():
        np.testing.assert_allclose([float(row[column]) for row in rows], values, rtol=1e-7, atol=1e-12)


def test_answer_and_summary_have_the_errors_of_the_files_on_common_lines(compared, overlay):
    """Not those on s = 1.6 mm, which only one has."""
    shown = page("", overlay, [])
    assert [column.head for column in shown.answer.heads] == ["scene", "nn", "cross terms"]
    assert [row.name for row in shown.answer.rows] == ["A", "", "B̂", ""]
    for row, variant in zip(shown.answer.rows, ("A", "A", "Bhat", "Bhat"), strict=True):
        name, cells = row.filled[0].text, [cell.below for cell in row.filled[1:]]
        errors = read(compared, f"{name}/errors.nc").error.sel(body="lower", line=LINE)
        for i, text in zip("ns", cells, strict=True):
            error, estimate = (100 * errors.sel(i=i, j="n", variant=one).item() for one in (variant, "C"))
            assert text.partition(" (")[0] == f"{with_estimate(error, estimate)} %"
        paragraph = shown.summary.splitlines()[list(overlay).index(name)]
        assert paragraph.startswith(f"{name}: Largest error of the lower ICs in nn: ")
        assert cells[0] in paragraph


def test_only_differences_are_listed(overlay):
    values = differences(ics_of(overlay))
    assert values["lower.E: Young's modulus [MPa]"] == ["210000", "70000"]
    listed = {key.split(": ")[0]: value for key, value in values.items()}
    for key, both in (
        ("lower.contour.flank_inclination_deg", ["20", "50"]),
        ("reference_length", ["10", "4"]),  # that of gentle is a default
        ("moment_arm", ["3.75", "2"]),  # 60 / 16, 4 / 2: computed
        ("lines.1.along", ["s", "–"]),
    ):
        assert listed[key] == both
    same = {"lower.nu", "upper.E", "patch.a", "engine.far_radius", "rotation_reach"}
    assert not same & listed.keys()
    assert not {key for key in listed if key.startswith("computed with")}


def differences_with(overlay, **attributes):
    """The differences if the second results had other attributes, by key."""
    first, second = ics_of(overlay).values()
    found = differences({"gentle": first, "steep": second.assign_attrs(attributes)})
    return {key.split(": ")[0]: values for key, values in found.items()}


def test_other_versions_and_settings_that_were_computed_are_listed_with_their_values(overlay):
    attributes = overlay["steep"].ics.attrs
    versions = json.loads(attributes["versions"]) | {"gmsh": "0.1"}
    settings = json.loads(attributes["settings"]) | {
        "first smallest_cell [mm]": 0.05,
        "first growth": 0.2,
        "first line_growth": 0.07,
    }
    values = differences_with(
        overlay, versions=json.dumps(versions), code="0123456789ab", settings=json.dumps(settings)
    )
    assert values["computed with gmsh"][1] == "0.1"
    assert values["computed with code"] == [attributes["code"], "0123456789ab"]
    assert "computed with femic" not in values
    assert values["engine.smallest_cell"] == ["0.1", "0.05"]
    assert values["engine.growth"] == ["0.5", "0.2"]
    assert values["engine.line_growth"] == ["0.4", "0.07"]


def test_results_up_to_date_and_folders_are_not_computed_again(copied, computed):
    assert compare(copied, *SCENES) == DONE
    (copied / "steep.toml").unlink()
    out = copied / "elsewhere"
    assert compare(copied, "gentle.toml", "results/steep", out=out) == DONE
    assert computed == []
    assert "steep" in (out / "report.html").read_text(encoding="utf-8")


def test_results_of_changed_scene_are_computed_again(copied):
    changed = (copied / "steep.toml").read_text(encoding="utf-8") + "# changed\n"
    (copied / "steep.toml").write_text(changed, encoding="utf-8")
    before = (copied / "results/gentle/ics.nc").stat().st_mtime_ns
    assert compare(copied, *SCENES) == DONE
    assert read(copied, "steep/ics.nc").attrs["scene"] == changed
    assert (copied / "results/gentle/ics.nc").stat().st_mtime_ns == before
    assert "# changed" in (copied / "results/gentle_steep/report.html").read_text(encoding="utf-8")


def other_code(path):
    """Results of the same models whose formulas have changed."""
    xr.load_dataset(path, engine="h5netcdf").assign_attrs(code="0123456789ab").to_netcdf(
        path, engine="h5netcdf"
    )


DAMAGE = {
    "missing": lambda path: path.unlink(),
    "broken": lambda path: path.write_text("not NetCDF", encoding="utf-8"),
    "of other code": other_code,
}


@pytest.mark.parametrize("name", ["ics.nc", "errors.nc"])
@pytest.mark.parametrize("case", DAMAGE)
def test_results_that_are_not_those_of_this_program_are_computed_again(name, case, copied, computed):
    DAMAGE[case](copied / "results" / "steep" / name)
    assert compare(copied, *SCENES) == INTERRUPTED
    assert computed == ["steep"]


def test_folder_with_changed_files_is_refused(copied, capsys):
    """Its numbers would not be what its text says."""
    path = copied / "results" / "steep" / "errors.nc"
    errors = read(copied, "steep/errors.nc")
    (errors * 2).to_netcdf(path, engine="h5netcdf")
    assert compare(copied, str(copied / "results/steep"), str(copied / "results/gentle")) == WRONG_INPUT
    assert "errors.nc: changed since `femic run` wrote it" in " ".join(capsys.readouterr().err.split())


ALL = 'bodies = ["upper"]\ncomponents = ["xx"]\nvariants = ["A"]'
BAD = {
    "none": ([], r"scenes = none: 0 given; give 2 to 5"),
    "one": (["gentle.toml"], r"scenes = \S*gentle\.toml: 1 given; give 2 to 5"),
    "twice": (["gentle.toml", "gentle.toml"], r"'gentle' twice; give different scenes"),
    "of the same name": (["gentle.toml", "results/gentle"], r"'gentle' twice; .* rename one"),
    "nothing in common": (
        ["gentle.toml", "other.toml"],
        r"bodies = \[lower\] of gentle against \[upper\] of other: nothing in common; add(.|\n)*"
        r"components = \[nn, sn, xn\] of gentle against \[xx\] of other(.|\n)*"
        r"lines = \[s = 1\.6 mm, x = 1\.6 mm\] of gentle against \[s = 0 mm\] of other",
    ),
    "no such scene": (["gentle.toml", "nowhere.toml"], r"neither a file nor a built-in scene"),
    "no results": (
        ["gentle.toml", "empty"],
        r"empty: no ics\.nc and errors\.nc of femic in this folder (.|\n)*give one that",
    ),
}


@pytest.mark.parametrize("case", BAD)
def test_unsuitable_scenes_are_refused_before_computation(case, copied, computed, capsys):
    scenes, expected = BAD[case]
    (copied / "empty").mkdir()
    (copied / "other.toml").write_text(scene_text(ALL, lines=ALONG_X), encoding="utf-8")
    if case != "of the same name":
        (copied / "results" / "gentle" / "ics.nc").unlink()  # would have to be computed
    before = sorted(copied.rglob("*"))
    assert compare(copied, *scenes) == WRONG_INPUT
    message = capsys.readouterr().err
    assert re.search(expected, message), message
    assert computed == []
    assert sorted(copied.rglob("*")) == before


@pytest.mark.parametrize(
    ("out", "expected"),
    [
        ("steep.toml", "this is a file; name a folder"),
        ("results/steep", "this folder holds the results of a scene; name another"),
    ],
)
def test_overlay_does_not_overwrite_results(out, expected, copied, computed, capsys):
    (copied / "results" / "gentle" / "ics.nc").unlink()
    assert compare(copied, *SCENES, out=copied / out) == WRONG_INPUT
    assert f"{out}: {expected}" in capsys.readouterr().err
    assert computed == []
