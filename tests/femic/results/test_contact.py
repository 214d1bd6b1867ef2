"""Contact of scenes: what is refused before any work, cases by name, files of extra gaps."""

import numpy as np
import pytest
import xarray as xr

from femic.results.contact import case_names, compute_contact, padded, pressures
from femic.scenes.errors import BadScene
from geometries.errors import Failure
from tests.femic.contact.wheel_on_rail import FLANKS, scene

SMALL = 2.0  # N: a patch of a degree in all, b / R = 0.006


def test_loads_that_hardly_differ_are_separate_cases():
    """One that is given twice is refused: cases are known by their loads."""
    dataset = compute_contact(scene(loads=[2000.0001, 2e3], ics=["A"]))
    assert list(dataset.case.values) == [2000.0001, 2e3]
    assert dataset.case.attrs == {"units": "N", "long_name": "prescribed load"}
    assert case_names(dataset) == ["2000.0001 N", "2000 N"]
    for key, same in (("loads", [5.0, 5.0]), ("approaches", [0.1, 0.1 * (1 + 1e-14)])):
        with pytest.raises(BadScene, match=rf"contact\.{key} = .*: .* given twice: name each once"):
            scene(**{key: same})


def test_scenes_without_loads_or_with_unavailable_ics_are_refused():
    with pytest.raises(BadScene, match=r"\[contact\]: give loads = .* in N, or approaches = .* in mm"):
        compute_contact(scene())
    with pytest.raises(BadScene, match=r"contact\.ics: Bhat_prime needs effective properties of both bodies"):
        compute_contact(scene(loads=[1.0], ics=["Bhat_prime"]))
    with pytest.raises(BadScene, match="give either loads or approaches"):
        scene(loads=[1.0], approaches=[1.0])


def with_gap(folder, points, **contact):
    """The scene with an extra gap at points (x, s, gap)."""
    file = folder / "gap.txt"
    np.savetxt(file, points)
    return scene(extra_gap=str(file), **contact)


@pytest.mark.parametrize(
    ("points", "says"),
    [
        ([(0.0,)] * 3, r"line 1: 1 columns; give s, gap or x, s, gap"),
        ([(0.0, 0.0, 0.0)] * 3, r"points 1 and 2 are at the same place"),
        ([(x, 0.0, 0.0) for x in range(3)], r"3 points lie on one line that is not at a single x"),
    ],
)
def test_files_of_an_extra_gap_are_checked(points, says, tmp_path):
    with pytest.raises(BadScene, match=rf"contact\.extra_gap = .*gap\.txt: (gap\.txt, )?{says}"):
        with_gap(tmp_path, points, loads=[SMALL])


def test_gaps_that_raise_a_surface_too_far_are_refused(tmp_path):
    """Far beside reference_length, here 10 mm: the surface would have another shape."""
    corners = [(x, s) for x in (-50.0, 50.0) for s in (-9.0, 9.0)]
    with_gap(tmp_path, [(*at, -1.0) for at in corners], loads=[SMALL])
    with pytest.raises(
        BadScene, match=r"contact\.extra_gap: -1\.1 mm raises .* 10% of reference_length, 1 mm"
    ):
        with_gap(tmp_path, [(*at, -1.1) for at in corners], loads=[SMALL])


def test_lateral_force_beyond_the_steepest_flank_is_refused():
    """Nearly all of what the steepest flank would bear if it alone touched; and more, before any work."""
    steepest = 2e4 * np.tan(np.radians(FLANKS))

    def sideways(share):
        return scene(10.3, loads=[2e4], elements=12, lateral_force=-share * steepest)

    with pytest.raises(Failure, match=r"reaches the end of a contour|lateral force: not reached|no grid"):
        compute_contact(sideways(0.99))
    with pytest.raises(BadScene, match=r"contact\.lateral_force = .*: without friction it is at most"):
        compute_contact(sideways(1.01))


def test_arrays_of_cases_end_in_nan_where_others_are_larger():
    one, other = np.arange(6.0).reshape(2, 3), np.arange(4.0).reshape(4, 1)
    whole = padded([one, other])
    assert whole.shape == (2, 4, 3)
    np.testing.assert_array_equal(whole[0, :2], one)
    np.testing.assert_array_equal(whole[1, :, :1], other)
    assert np.isnan(whole).sum() == 2 * 12 - 6 - 4


def test_pressures_of_a_case_are_those_on_its_own_grid():
    places = {
        "x": (("case", "x"), padded([np.array([-1.0, 0.0, 1.0]), np.zeros(1)])),
        "s": (("case", "s"), [[0.0, 2.0]] * 2),
    }
    p = padded([np.full((1, 3, 2), 5.0), np.full((1, 1, 2), 7.0)])
    dataset = xr.Dataset({"p": (("case", "ics", "x", "s"), p)}, places | {"ics": ["A"], "case": [1.0, 2.0]})
    for number, (x, value) in enumerate([([-1.0, 0.0, 1.0], 5.0), ([0.0], 7.0)]):
        own = pressures(dataset, number)
        np.testing.assert_array_equal(own.x, x)
        np.testing.assert_array_equal(own, np.full((1, len(x), 2), value))
