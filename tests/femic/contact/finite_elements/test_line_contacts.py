"""Closed forms of line contacts, in plane strain: a cylinder on a block, and a pin that fits its hole.

The pin is the closed form of conforming contact: its pressures are not those of half-planes.
"""

import numpy as np
import pytest

from femic.contact.exact.hertz import LineContact, combined_modulus
from geometries.materials import Material
from geometries.surfaces import LOWER, UPPER
from tests.femic.contact.exact.pin import PinInHole
from tests.femic.contact.finite_elements.ellipse import BRASS, STEEL
from tests.femic.contact.finite_elements.slices import OVERHANG, Cells, block, pressed, round_section

SIMILAR = Material(500e3, 0.0), Material(50e3 * 1.45, 0.45)  # of Dundurs' beta 0, though not equal
HUB = 0.03  # radius at which pins are held, as a share of their own
FAR = 40.0  # half-widths or radii to the ends of blocks and plates: errors of 1 / 1600
INSIDE = 0.8  # of the half-width: there pressures are smooth


def difference(level, truth, half_width):
    """Root mean square over the inside of the patch, over the largest pressure.

    Pressures are means over the slice: they differ from side to side, as the cells do.
    """
    s, of = np.unique(np.round(level.pair.s, 9), return_inverse=True)
    p = np.bincount(of, level.p) / np.bincount(of)
    inside = s < INSIDE * half_width
    return np.sqrt(np.mean((p - truth(s))[inside] ** 2)) / truth(0.0)


def check_numbers(level, truth, half_width):
    """The largest pressure within 0.4 %, the edge within 0.3 spacings: few vertices are left beyond it."""
    assert level.p.max() == pytest.approx(truth(0.0), rel=0.004)
    assert level.s_range[1] == pytest.approx(half_width, abs=0.3 * level.spacing)
    assert level.reactions == pytest.approx((level.load, -level.load), rel=1e-5)


def test_a_cylinder_on_a_block_converges_to_hertz():
    """Its patch is so narrow, a 30th of the radius, that half-planes are right within 0.1 %."""
    half_width, radius = 1.0, 30.0
    line = LineContact(1 / radius, combined_modulus(STEEL, BRASS))
    load = np.pi * line.modulus * half_width**2 / (4 * radius)
    errors = []
    for count in (5.0, 10.0):
        cells = Cells(half_width / count, count)
        mesh = {"cells": cells, "equal_to": 1.4 * half_width + 2 * cells.smallest}
        lower = block(STEEL, depth=FAR * half_width, **mesh)
        upper = round_section(UPPER, BRASS, radius, depth=(1 - HUB) * radius, **mesh)
        level = pressed(lower, upper, cells, load)
        check_numbers(level, lambda s: line.pressure(load, s), half_width)
        errors.append(difference(level, lambda s: line.pressure(load, s), half_width))
    assert errors[1] < 0.004
    assert errors[1] < errors[0] / 2  # first order, or better


@pytest.mark.parametrize(
    ("materials", "half_angle", "count"),
    [((STEEL, STEEL), 45.0, 10.0), (SIMILAR, 45.0, 10.0), ((STEEL, STEEL), 60.0, 14.0)],
    ids=["equal", "similar", "equal, 120 degrees"],
)
def test_pin_in_a_fitting_hole_agrees_with_persson(materials, half_angle, count):
    """Pressures over 90 and 120 degrees. Hertz's are at least a fifth too small."""
    radius, clearance, angle = 12.0, 0.012, np.radians(half_angle)
    pin = PinInHole(*materials, radius, clearance)
    load, half_width = pin.load(angle), radius * angle
    cells = Cells(half_width / count, count)

    def truth(s):
        return pin.pressure(load, np.minimum(s / (radius + clearance), angle))

    mesh = {"cells": cells, "equal_to": OVERHANG * radius - cells.smallest}
    hole = round_section(LOWER, pin.hole, radius + clearance, depth=FAR * radius, **mesh)
    shaft = round_section(UPPER, pin.pin, radius, depth=(1 - HUB) * radius, **mesh)
    level = pressed(hole, shaft, cells, load)
    check_numbers(level, truth, half_width)
    assert difference(level, truth, half_width) < 0.004
    hertz = LineContact(1 / radius - 1 / (radius + clearance), pin.modulus)
    assert hertz.p_max(load) < 0.8 * truth(0.0)
