"""The lateral position that a force asks for."""

import pytest

from femic.contact.lateral_force import contact_at_lateral_force
from geometries.errors import Failure


@pytest.mark.parametrize(("force", "position"), [(-12.0, 3.0), (4.0, -1.0), (0.0, 0.0), (-8.0, 2.0)])
def test_the_position_of_a_spring_is_found_with_its_stiffness(force, position):
    contact, found, stiffness = contact_at_lateral_force(
        lambda y: (-4.0 * y, f"at {y:.6f}"), force, start=2.0, step=0.1, accuracy=1e-9
    )
    assert found == pytest.approx(position, abs=1e-8)
    assert contact == f"at {found:.6f}"
    assert stiffness == pytest.approx(4.0)


def test_a_force_that_is_not_reached_is_an_error_with_the_positions_tried():
    with pytest.raises(Failure, match=r"not reached with the upper body between -\d.* give a `shift`"):
        contact_at_lateral_force(lambda y: (1.0 / (1.0 + y * y), y), 3.0, start=0.5, step=1e-6, accuracy=1e-9)
