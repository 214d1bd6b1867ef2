"""C in the contacts of tests with friction, on several supports."""

from dataclasses import replace
from types import SimpleNamespace

import pytest

from tests.compare.friction.scenes import REFERENCE_ICS, bhat_as_c

SAME, SOFTER = "the same", "a fifth softer"


@pytest.fixture(scope="module")
def in_place_of_c():
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
