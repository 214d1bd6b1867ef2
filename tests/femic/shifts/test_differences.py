"""Estimated errors of differences between ICs on the same elements: finer elements, rounded points."""

from functools import cache

import numpy as np
import pytest

from compare.pages.shift_figures import difference, difference_estimate
from femic.shifts.contact import contact_at
from femic.shifts.sides import Place, lay_out_wheelset, prepare_sections
from femic.shifts.specification import ContactTable, parse_specification
from geometries.profiles.standards import standard
from geometries.track.wheelset import settle


def contact(wheel, folder, shift, elements=8):
    """The left contact of a wheel on 60E1 with A and B-hat."""
    table = {"shifts": [shift], "rail": {"profile": "60E1"}, "wheel": wheel}
    file = parse_specification(table, folder / "s.toml")
    layout = lay_out_wheelset(file, prepare_sections(file))
    place = Place(layout, settle(layout, shift, roll="about rails"), "left")
    asked = ContactTable(load=9e4, ics=("A", "Bhat"), elements=elements, planar=False)
    return contact_at(place, file.rail, file.wheel, asked).expand_dims(shift=[shift], side=["left"])


@cache
def exact(folder, shift, elements=8):
    return contact({"profile": "S1002"}, folder, shift, elements)


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    return tmp_path_factory.mktemp("profiles")


@pytest.mark.parametrize("shift", [5.0, 6.5])
def test_a_difference_on_finer_elements_is_within_its_estimate(folder, shift):
    """On the tread and in the flange root: much less than the estimated error of p_max itself."""
    coarse, fine = (exact(folder, shift, elements) for elements in (8, 16))
    own, finer = (difference(one, "A").item() for one in (coarse, fine))
    estimate = difference_estimate(coarse, "A").item()
    assert abs(own - finer) <= estimate
    of_p_max = (coarse.estimate_p_max / coarse.p_max).sel(ics="Bhat").item()
    assert estimate < of_p_max / 5


@pytest.mark.parametrize("shift", [5.0, 6.5])
def test_rounded_points_change_p_max_with_all_ics_alike(folder, shift):
    """Points with two decimals, not smoothed: the difference changes by a small part of p_max's change."""
    outline = standard("S1002").outline
    points = outline.position(np.arange(0.25, outline.length, 0.57))  # no multiple of steps
    np.savetxt(folder / "rounded.txt", points.T, fmt="%.2f")
    file = {"profile": "rounded.txt", "axes": "field up", "flange_back": -70.0}
    rounded, without = contact(file, folder, shift), exact(folder, shift)
    moved = abs(rounded.p_max / without.p_max - 1).min().item()
    change = abs(difference(rounded, "A") - difference(without, "A")).item()
    assert moved > 0.1
    assert change < 0.1 * moved
    assert change <= difference_estimate(rounded, "A").item()
