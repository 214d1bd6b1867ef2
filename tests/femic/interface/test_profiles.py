"""Profiles in Python: read, placed and written as in scene files; a wheelset of them against Hertz."""

import numpy as np
import pytest
import xarray as xr

import femic
from femic.contact.exact.hertz import PointContact, combined_modulus
from femic.interface.options import make_scene
from femic.results import wheelset_contacts
from geometries.profiles.standards import standard_profile
from tests.samples import ERROR, write_head

STEEL = femic.Material(E=210e3, nu=0.28)
RADIUS, CROWN = 30.0, 2.0  # mm, of the arc in the file, and y of its crown
AXES = {"kind": "rail", "axes": "field up", "unit": "mm"}
RAIL, CONE = femic.Profile(standard="60E1"), femic.Profile(standard="cone-1-20")


@pytest.fixture(scope="module")
def head(tmp_path_factory):
    """An arc from a file whose points err, smoothed."""
    path = tmp_path_factory.mktemp("profiles") / "head.txt"
    write_head(path)
    return femic.Profile(path, **AXES, tolerance=ERROR)


def test_an_arc_of_a_file_has_the_ics_of_the_exact_one(head):
    """Points whose errors alternate by 20 µm are smoothed to the arc; ICs off the crown, along s."""
    plane = femic.Body(femic.plane(), STEEL)
    rails = head.at(CROWN, steepest_deg=60.0), femic.arc(RADIUS, 60.0)
    ours, exact = (
        femic.compute_ics(
            femic.Pair(plane, femic.Body(rail, STEEL), reference_length=10.0),
            femic.Patch(0.3, 0.2, s=4.0),
            [femic.line_along_s(x=1.6, reach=8.0, points=15)],
            ["A", "Bhat"],
        ).ic
        for rail in rails
    )
    assert np.max(np.abs(ours - exact)) < 1e-3 * np.max(np.abs(exact))


def test_the_data_say_how_the_file_was_understood(head):
    data = head.data
    assert data.attrs["kind"] == "rail"
    assert "1 unit of the file is 1 mm, as given" in data.attrs["notes"]
    assert np.sqrt(np.mean(data.residual**2)) == pytest.approx(ERROR, rel=1e-3)
    middle = data.sel(s=slice(5, data.s.max() - 5))
    np.testing.assert_allclose(np.hypot(middle.y - CROWN, middle.z - 1 + RADIUS), RADIUS, atol=2e-3)
    np.testing.assert_allclose(np.sin(middle.inclination), (middle.y - CROWN) / RADIUS, atol=2e-3)


def test_a_section_of_a_list_is_the_profile_of_its_file(tmp_path, head):
    femic.write_profile(head, tmp_path / "head.prr")
    femic.write_profile(RAIL, tmp_path / "other.prr")
    (tmp_path / "rail.slcs").write_text("0 1\n2\n0 0 0\n1\n0 head.prr\n1000 other.prr\n")
    by_number = femic.Profile(tmp_path / "rail.slcs", section=1)
    by_position = femic.Profile(tmp_path / "rail.slcs", section_at=1000.0)
    for section, file in ((by_number, "head.prr"), (by_position, "other.prr")):
        alone = femic.Profile(tmp_path / file)
        np.testing.assert_array_equal(section.data.z, alone.data.z)
        assert section.at(0.0).contour().limits == alone.at(0.0).contour().limits


def test_a_worn_profile_of_the_package_lies_within_the_new_one():
    y = np.linspace(-30, 30, 13)
    new, worn = (femic.Profile(standard=name).data for name in ("60E1", "60E1-worn"))
    off = np.interp(y, new.y, new.z) - np.interp(y, worn.y, worn.z)
    assert np.all(off > -0.01)  # mm, of smoothing
    assert np.max(off) > 0.5


def test_contours_end_where_they_are_steepest():
    contour = RAIL.at(0.0, steepest_deg=50.0).contour()
    np.testing.assert_allclose(np.degrees(contour.inclination([-50, 50])), [-50, 50], rtol=1e-9)


def test_pairs_of_profiles_are_those_of_a_scene_file():
    """The placed profiles are the tables of the built-in scene, and make its bodies."""
    file, made = femic.load_pair("s1002-on-60e1"), {}
    for body, standard in (("upper", "S1002"), ("lower", "60E1")):
        of_file, table = getattr(file, body), getattr(file, body).contour
        placed = ("y_centre", "rail_inclination", "turn_deg", "steepest_deg")
        contour = femic.Profile(standard=standard).at(**{key: getattr(table, key) for key in placed})
        made[body] = femic.Body(contour, of_file.material, of_file.rolling_radius, of_file.hub_radius)
    ours = femic.Pair(**made, reference_length=file.reference_length)
    first, second = (make_scene(pair, femic.Options()).bodies for pair in (ours, file))
    s = np.linspace(-15, 15, 61)
    for body in made:
        np.testing.assert_array_equal(*(bodies[body].contour.position(s) for bodies in (first, second)))


def test_profiles_are_written_and_read_back(head, tmp_path):
    """Standards point by point; a smoothed file as its smooth curve."""
    femic.write_profile(RAIL, tmp_path / "60E1.prr")
    again = femic.Profile(tmp_path / "60E1.prr").data
    np.testing.assert_array_equal([again.point_y, again.point_z], standard_profile("60E1").points)
    femic.write_profile(head, tmp_path / "head.prr")
    smooth = femic.Profile(tmp_path / "head.prr").data
    inner = smooth.isel(point=slice(20, -20))
    np.testing.assert_allclose(np.hypot(inner.point_y - CROWN, inner.point_z - 1 + RADIUS), RADIUS, atol=2e-3)


def test_the_figure_shows_section_residual_inclination_and_curvature(head):
    panels = femic.plot_profile(head).axes
    assert [panel.get_title() for panel in panels] == ["", "Residual", "Inclination", "Curvature"]
    drawn = panels[3].lines[0].get_ydata()
    np.testing.assert_allclose(drawn, head.data.curvature)
    assert len(femic.plot_profile(RAIL).axes) == 3  # a standard has no residual


@pytest.fixture(scope="module")
def study():
    """A cone on the crown of a rail, radius 300 mm, with small loads; without the conicity, which is dear."""
    tables = {"contact": {"ics": ["A"], "load": 1e3, "elements": 12}, "wheel": {"E": 105e3}}
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(wheelset_contacts, "conicity", lambda *_, **__: xr.Dataset())
        return femic.compute_shifts(RAIL, CONE, [0.0, 1.0], tables=tables, options=femic.Options(workers=1))


def test_a_cone_on_the_crown_presses_as_hertz_says(study):
    """Across, 300 mm on a straight line; along, the rolling radius by the cosine of the contact angle."""
    at = study.sel(shift=0.0, side="left", ics="A")
    angle = np.radians(at.contact_angle.item())
    assert np.tan(angle) == pytest.approx(1 / 20, rel=1e-6)
    modulus = combined_modulus(femic.Material(105e3, 0.28), STEEL)
    along = np.cos(angle) / at.radius.item()
    hertz = PointContact(along, 1 / 300, modulus).at_load(1e3 / np.cos(angle))
    assert at.p_max.item() == pytest.approx(hertz.p_max, rel=0.01)
    assert study.refused == "{}"


def test_both_sides_carry_the_load_and_are_mirrored(study):
    np.testing.assert_allclose(study.vertical, 1e3, rtol=1e-6)
    middle = study.sel(shift=0.0)
    np.testing.assert_allclose(middle.p_max.sel(side="left"), middle.p_max.sel(side="right"), rtol=1e-9)
    moved = study.sel(shift=1.0)
    assert moved.radius.sel(side="left") > moved.radius.sel(side="right")


def test_a_measured_rail_is_solved_as_it_was_read_and_smoothed(head, monkeypatch):
    """The specification that is solved has the file with its axes, unit and tolerance, and further keys."""
    seen = []
    monkeypatch.setattr("femic.results.wheelset.compute_shifts", lambda file, *_: seen.append(file))
    femic.compute_shifts(head, CONE, [0.0], tables={"rail": {"nu": 0.3}})
    (rail,) = (file.rail for file in seen)
    assert (rail.profile, rail.axes, rail.unit) == (str(head.file), "field up", "mm")
    assert (rail.tolerance, rail.nu, seen[0].wheel.profile) == (ERROR, 0.3, "cone-1-20")


def test_the_figure_of_a_study_has_its_pressures(study):
    left = femic.plot_contact(study).axes[0]
    curves = [line for line in left.lines if line.get_label() in study.ics.values]
    assert set(study.ics.values) == {"A", "planar"}
    expected = {tuple(np.round(study.p_max.sel(side="left", ics=name).values, 6)) for name in study.ics}
    assert {tuple(np.round(curve.get_ydata(), 6)) for curve in curves} == expected
    for curve in curves:
        np.testing.assert_allclose(curve.get_xdata(), study["shift"])


def test_wrong_profiles_are_refused_with_the_reason(tmp_path):
    turned, plane = femic.Body(CONE.at(0.0, turn_deg=1.0), STEEL, 460.0), femic.Body(femic.plane(), STEEL)
    write_head(tmp_path / "head.txt")
    for make, message in (
        (lambda: femic.Profile("nowhere.prr"), "nowhere.prr"),
        (lambda: femic.Profile(tmp_path / "head.txt"), "give kind = 'rail' or 'wheel'"),
        (lambda: make_scene(femic.Pair(turned, plane), femic.Options()), "turn"),
    ):
        with pytest.raises(femic.WrongInput, match=message):
            make()
