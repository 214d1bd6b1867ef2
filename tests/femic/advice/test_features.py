"""Features of contacts that advice is looked up by."""

from types import SimpleNamespace

import numpy as np
import pytest

from femic.advice.knowledge import turn_beyond
from geometries.contours import arc


@pytest.mark.parametrize("flanks", [(20.0, 50.0), (50.0, 20.0)])
@pytest.mark.parametrize("narrow", ["lower", "upper"])
def test_what_liesturn_beyond_a_patch_is_that_of_the_body_and_the_side_with_the_least(narrow, flanks):
    """A patch from -12 to 15 degrees: to a flank of 20 degrees it has 8 or 5 degrees left, to others more."""
    wide = "upper" if narrow == "lower" else "lower"
    contours = {narrow: arc(10.0, *np.radians(flanks)), wide: arc(11.0, np.radians(60.0), np.radians(61.0))}
    problem = SimpleNamespace(bodies={name: SimpleNamespace(contour=one) for name, one in contours.items()})
    least = 8.0 if flanks[0] == 20.0 else 5.0
    assert turn_beyond(problem, np.array([-12.0, 15.0])) == pytest.approx(least)
