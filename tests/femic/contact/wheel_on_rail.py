"""A wheel on a rail, arcs, small or conforming, and B-hat in the place of its C."""

from contextlib import contextmanager
from dataclasses import replace
from types import SimpleNamespace

import pytest

from approx.pair import matrix
from femic.contact.operators.dense import Asymmetry, GridOperator
from femic.contact.pairs.ics import ReferenceICs
from femic.scenes.load import scene_from_table

REFERENCE_ICS = "femic.contact.pairs.pair_with_friction.full_reference_ics"

RADIUS, WHEEL, ROLLING, FLANKS = 10.0, 14.0, 400.0, 60.0
STEEL = {"E": 210e3, "nu": 0.3}
SAME, SOFTER = "the same", "a fifth softer"  # other supports, in tests


def scene(upper_radius=WHEEL, rolling_radius=ROLLING, tolerance=0.01, upper=(), lower=(), **contact):
    """A wheel of revolution on a rail, with the keys of [contact]; other keys of a body replace its own."""
    arcs = [
        STEEL | {"contour": {"kind": "arc", "radius": radius, "flank_inclination_deg": FLANKS}}
        for radius in (RADIUS, upper_radius)
    ]
    return scene_from_table(
        {
            "lower": arcs[0] | dict(lower),
            "upper": arcs[1] | {"rolling_radius": rolling_radius} | dict(upper),
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


@contextmanager
def bhat_in_place_of_c():
    """C is B-hat; C with other supports is the same, and a fifth more."""

    def supports(problem, name, factor):
        def scaled(on_grid, **_):
            operator = bhat_as_c()(problem, on_grid).operator
            return replace(operator, transformed=factor * operator.transformed)

        return SimpleNamespace(name=name, operator=scaled)

    def others(problem, *_):
        return [supports(problem, SAME, 1.0), supports(problem, SOFTER, 1.2)]

    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(REFERENCE_ICS, bhat_as_c())
        patch.setattr("femic.contact.supports.other_supports", others)
        yield
