"""A wheel on a rail with friction, small or conforming, for tests."""

from femic.scenes.load import scene_from_table

RADIUS, WHEEL, ROLLING = 10.0, 14.0, 400.0


def scene(upper_radius=WHEEL, rolling_radius=ROLLING, tolerance=0.01, **contact):
    """A wheel of revolution on a rail, arcs of equal material, with the keys of [contact]."""
    lower = {"kind": "arc", "radius": RADIUS, "flank_inclination_deg": 60.0}
    upper = lower | {"radius": upper_radius}
    material = {"E": 210e3, "nu": 0.3}
    return scene_from_table(
        {
            "lower": {**material, "contour": lower},
            "upper": {**material, "contour": upper, "rolling_radius": rolling_radius},
            "patch": {"a": 0.1, "b": 0.1},
            "engine": {"tolerance": tolerance},
            "contact": {"ics": ["A", "Bhat"], "elements": 8} | contact,
        },
        "pair",
    )
