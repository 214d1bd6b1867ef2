"""A wheel whose points are written with two decimals, in contact: p_max, and what is stated of it."""

import numpy as np
import pytest

from femic.shifts.contact import contact_at, read_grids
from femic.shifts.sides import Place, lay_out_wheelset, prepare_sections
from femic.shifts.specification import ContactTable, parse_specification
from geometries.profiles.noise import peak_slope
from geometries.profiles.standards import standard
from geometries.track.wheelset import settle

WANTED = ContactTable(load=80e3, ics=("A",), elements=12, planar=False)
HALF_STIFFNESS = 210e3 / (2 * (1 - 0.28**2)) / 2  # E*/2 of two steel bodies [MPa]


def solved(wheel, folder):
    """p_max, its estimate, and the part of this by E*/2 times the slope that rounding adds, in the middle."""
    table = {"shifts": [0.0], "rail": {"profile": "60E1"}, "wheel": wheel}
    specification = parse_specification(table, folder / "s.toml")
    sections = prepare_sections(specification)
    layout = lay_out_wheelset(specification, sections)
    place = Place(layout, settle(layout, 0.0), "left")
    contact = contact_at(place, specification.rail, specification.wheel, WANTED)
    p_max, estimate, b = (contact[name].item() for name in ("p_max", "estimate_p_max", "b"))
    added = peak_slope(sections[2].curve, place.touch.s_wheel, b, read_grids(contact)[0].ds)
    return p_max, estimate, HALF_STIFFNESS * added


def test_a_rounded_cone_has_a_p_max_within_what_is_stated_and_the_right_one_when_smoothed(tmp_path):
    outline = standard("cone-1-20").outline
    points = outline.position(np.arange(0.1, outline.length, 0.57))  # no multiple of steps
    np.savetxt(tmp_path / "cone.txt", points.T, fmt="%.2f")
    file = {"profile": "cone.txt", "axes": "field up", "flange_back": -70.0}
    exact, own, none = solved({"profile": "cone-1-20"}, tmp_path)
    assert none == 0
    raw, raw_own, raw_added = solved(file, tmp_path)
    smooth, smooth_own, smooth_added = solved(file | {"tolerance": 0.003}, tmp_path)
    assert raw > 1.2 * exact
    assert raw - exact < raw_own + own < 5 * (raw - exact)  # the estimate knows it
    assert raw_own > 0.9 * raw_added > 0.5 * raw_own
    assert smooth == pytest.approx(exact, rel=0.05)  # some percent are left: waves of 5 mm
    assert abs(smooth - exact) < smooth_own + own
    assert smooth_added < 0.2 * raw_added
