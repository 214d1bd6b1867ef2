"""The page of a profile: its sentences, its table and its charts have the numbers of an arc with errors."""

from pathlib import Path

import numpy as np
import pytest

from compare.pages.profiles import (
    answer_table,
    doubts,
    over_length,
    section,
    summary,
    write_profile_page,
)
from compare.report.tables import MINUS
from femic.results.profiles import file_profile, package_profile
from femic.scenes.profiles import Reading, prepared_file
from geometries.profiles.noise import LEAST_RADIUS
from geometries.profiles.standards import NAMED
from tests.compare.pages import read_chart, read_texts, require_room
from tests.samples import ERROR, write_head


@pytest.fixture
def head(tmp_path, monkeypatch):
    """A folder with a file of an arc of 30 mm, its crown at (2, 1), with errors of alternating sign."""
    monkeypatch.chdir(tmp_path)
    write_head(tmp_path / "mine.txt")
    return tmp_path


def understood(tolerance=0.0):
    path = Path("mine.txt")
    return file_profile(prepared_file(path, Reading("rail", "field", tolerance=tolerance)), path)[0]


@pytest.mark.usefixtures("head")
def test_table_has_the_numbers_of_the_arc():
    one = understood(ERROR)
    rows = read_texts(answer_table(one))
    assert float(rows["moved by smoothing [mm]"][0]) == pytest.approx(
        float(abs(one.residual).max()), rel=0.05
    )
    assert float(rows["least radius, convex [mm]"][0]) == pytest.approx(30, rel=0.05)
    assert abs(float(rows["steepest [deg]"][0].replace(MINUS, "-"))) == pytest.approx(
        np.degrees(1.4), abs=0.5
    )


@pytest.mark.usefixtures("head")
def test_charts_have_the_points_and_the_curve():
    one = understood(ERROR)
    (drawn,) = read_chart(section(one))["steps"][0]
    points, curve = drawn["traces"]
    given, size = [one.point_y, one.point_z], np.ptp(one.point_y.values)
    np.testing.assert_allclose([points["x"], points["y"]], given, rtol=0, atol=1e-4 * size)
    np.testing.assert_allclose(np.hypot(np.array(curve["x"]) - 2, np.array(curve["y"]) + 29), 30, atol=2e-3)
    assert drawn["layout"]["yaxis"]["scaleanchor"] == "x"
    titles = [panel.title for panel in over_length(one).cells]
    assert titles == ["Residual", "Inclination", "Curvature"]
    residual, _, curvature = (panel.curves[0] for panel in over_length(one).cells)
    assert np.std(residual.y) == pytest.approx(1e3 * ERROR, rel=1e-2)
    assert np.median(curvature.y) == pytest.approx(1 / 30, rel=1e-3)
    assert [panel.title for panel in over_length(understood()).cells] == ["Inclination", "Curvature"]


@pytest.mark.slow
@pytest.mark.usefixtures("head")
def test_nothing_is_wider_than_the_window(browser, tmp_path):
    require_room(browser, write_profile_page(understood(ERROR), tmp_path / "page"), {400: 400, 800: 800})


@pytest.mark.usefixtures("head")
def test_a_radius_below_all_real_ones_looks_like_noise(tmp_path):
    """Errors of 20 um of alternating sign, 0.35 mm apart, bend to 1/r = 4 * 0.02 / 0.35^2, r = 1.5 mm."""
    raw, smoothed = understood(), understood(ERROR)
    said = raw.attrs["doubt"]
    assert 1 / np.max(np.abs(raw.curvature)) < LEAST_RADIUS
    assert "tolerance of 0.01 mm" in said
    assert said in write_profile_page(raw, tmp_path / "raw").read_text(encoding="utf-8")
    assert "not fit for contact as it is. Its points were not changed." in summary(raw)
    assert "84.0 mm long from the gauge side to the field side. It shows no noise" in summary(smoothed)
    assert "is fit for contact. Smoothing moved its points by up to 0.02" in summary(smoothed)
    assert not any(doubts(smoothed))
    assert not smoothed.attrs["doubt"]
    for name in NAMED:
        assert not package_profile(name)[0].attrs["doubt"]


@pytest.mark.usefixtures("head")
def test_shape_that_smoothing_removes_is_doubted():
    """A residual of three times the rms is noise, one of six times is not."""
    one = understood(ERROR)
    k, rms = 100, float(np.sqrt(np.mean(one.residual**2)))
    for share, is_doubted in ((3.0, False), (6.0, True)):
        residual = one.residual.copy()
        residual[k] = share * rms
        said = doubts(one.assign(residual=residual))[1]
        assert bool(said) == is_doubted
    assert f"At s = {float(one.point_s[k]):.1f} mm smoothing moves the points by {6 * rms:.2g} mm, " in said
    assert "may have removed some of its shape" in summary(one.assign(residual=residual))


def test_standard_has_the_radii_of_its_definition():
    rail, s1002 = (package_profile(name)[0] for name in ("60E1", "S1002"))
    rows = {row.name: row.filled for row in answer_table(rail).rows}
    assert rows["least radius, convex [mm]"][0].text == "13"
    assert "moved by smoothing [mm]" not in rows
    wheel = {row.name: row.filled[0].text for row in answer_table(s1002).rows}
    assert (wheel["least radius, convex [mm]"], wheel["least radius, hollow [mm]"]) == ("12", "13")
    assert "EN 13674-1" in summary(rail)
