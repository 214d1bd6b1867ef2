import numpy as np
import pytest

from geometries.patches import Patch, line_along_s, line_along_x


def test_area_is_that_of_both_full_sides():
    assert Patch(a=0.3, b=0.2).area == pytest.approx((2 * 0.3) * (2 * 0.2), rel=1e-15)


@pytest.mark.parametrize(("a", "b"), [(0.0, 0.2), (0.3, 0.0), (-0.3, -0.2), (np.nan, 0.2), (0.3, np.nan)])
def test_half_sides_must_be_positive(a, b):
    with pytest.raises(ValueError, match=rf"a = {a!r}, b = {b!r} must be positive"):
        Patch(a, b)


def test_line_along_x_keeps_its_arc_length():
    line = line_along_x(1.6, 25.0, 11)
    assert (line.along, line.name) == ("x", "s = 1.6 mm")
    np.testing.assert_array_equal(line.s, 1.6)
    np.testing.assert_allclose(line.x, 5.0 * np.arange(-5, 6), rtol=1e-15)
    np.testing.assert_array_equal(line.running, line.x)


def test_line_along_s_keeps_its_distance():
    line = line_along_s(-0.4, (-7.0, 2.0), 4)
    assert (line.along, line.name) == ("s", "x = -0.4 mm")
    np.testing.assert_array_equal(line.x, -0.4)
    np.testing.assert_allclose(line.s, [-7.0, -4.0, -1.0, 2.0], rtol=1e-15)
    np.testing.assert_array_equal(line.running, line.s)
