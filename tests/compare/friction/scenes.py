"""A wheel on a rail with friction, small or conforming, for tests; B-hat in the place of its C."""

from approx.pair import matrix
from femic.contact.operators.dense import Asymmetry, GridOperator
from femic.contact.pairs.ics import ReferenceICs
from femic.scenes.load import scene_from_table

REFERENCE_ICS = "femic.contact.pairs.pair_with_friction.full_reference_ics"

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


def bhat_as_c(share=0.02):
    """Return a function for `full_reference_ics` that gives B-hat, with an estimate of a share of it."""

    def reference_ics(of, on_grid, *_, **__):
        operator = GridOperator.from_ics(matrix("Bhat", of.pair, on_grid.grid))
        perturbed = GridOperator((1 + share) * operator.transformed, operator.n_x)
        return ReferenceICs(operator, perturbed, share, Asymmetry(0.0, "nn"), 1.0, 0.0)

    return reference_ics
