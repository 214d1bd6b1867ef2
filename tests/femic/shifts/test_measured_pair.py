"""The measured heavy-haul pair of the samples across its track, to the flange."""

import numpy as np
import pytest

from compare.pages.shift_figures import difference
from femic.reference.run_options import RunOptions
from femic.results.wheelset import compute_shifts
from femic.shifts.contact import contact_at
from femic.shifts.sides import Place, lay_out_wheelset
from femic.shifts.specification import ContactTable, load_shifts
from geometries.track.wheelset import settle
from tests.samples import SAMPLES

RAIL, WHEEL = SAMPLES / "site_b_hr.prr", SAMPLES / "worn_high_mileage.prw"
# gauge, flange-back distance and radius are those of the samples' description; that the rail lies as it was
# measured and that the flange back is at y = 0 of the wheel's file is assumed
TEXT = """
shifts = [{shifts}]
[rail]
profile = "{rail}"
tolerance = 0.01
[wheel]
profile = "{wheel}"
tolerance = 0.01
flange_back = 0.0
[track]
gauge = 1435.1
gauge_depth = 15.875
rail_inclination = 0.0
[wheelset]
flange_back_distance = 1347.4
nominal_radius = 444.0
"""

pytestmark = [
    pytest.mark.slow,
    pytest.mark.skipif(
        not (RAIL.exists() and WHEEL.exists()),
        reason=f"no samples of profiles in {SAMPLES}: set FEMIC_PROFILES to their folder",
    ),
]


def specification(tmp_path, *shifts):
    path = tmp_path / "measured.toml"
    path.write_text(TEXT.format(shifts=", ".join(map(str, shifts)), rail=RAIL, wheel=WHEEL))
    return load_shifts(str(path))[2]


def test_half_spaces_are_as_good_as_b_hat_on_the_tread_and_where_three_patches_carry(tmp_path):
    """Vertical forces balance, mirrored shifts agree, and A is within 1 % of B-hat up to the flange."""
    file = specification(tmp_path, -15.4, 0.0, 15.4)
    dataset = compute_shifts(file, options=RunOptions(2))
    np.testing.assert_allclose(dataset.vertical.sel(ics="Bhat"), 9e4, rtol=2e-6)
    left, right = dataset.p_max.sel(side="left"), dataset.p_max.sel(side="right")
    np.testing.assert_allclose(left.values, right.values[::-1], rtol=1e-9)
    assert float(abs(difference(dataset, "A")).max()) < 0.01
    on_flange = dataset.sel(shift=15.4, side="left")
    assert np.all(on_flange.patches == 3)  # planar contact has a plane for each
    assert np.all(on_flange.p_max < dataset.p_max.sel(shift=0.0, side="left"))


def test_patches_lie_at_the_touching_points_of_the_undeformed_profiles(tmp_path):
    file = specification(tmp_path, 15.4)
    layout = lay_out_wheelset(file)
    position = settle(layout, 15.4, roll="about rails", within=0.1)
    touches = sorted(touch.s_rail for touch in position.left)
    asked = ContactTable(load=9e4, ics=("Bhat",), planar=False)
    contact = contact_at(Place(layout, position, "left"), file.rail, file.wheel, asked).isel(ics=0)
    patches = sorted(zip(contact.patch_start.values, contact.patch_end.values, strict=True))
    assert len(touches) == len(patches) == 3
    for touch, (start, end) in zip(touches, patches, strict=True):
        assert start < touch < end
