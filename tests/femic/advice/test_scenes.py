"""Random scenes: the same for the same seed and number, and as they were drawn; two of them solved again."""

import numpy as np
import pytest
from advice_reliability import ics_errors, reference_estimates
from advice_scenes import ANGLES, ELEMENTS, random_scene, solve_scene

from femic.advice.knowledge import FEATURES, contact_features, packaged_knowledge, saturation
from femic.contact.pairs.pair_on_grid import undeformed_surfaces

READING = 0.1 / ELEMENTS  # of edges: a twentieth of an element at both ends
SOLVED_AGAIN = 2


def test_scenes_are_determined_by_seed_and_number():
    one, same, other = (random_scene(*which) for which in ((3, 1), (3, 1), (3, 2)))
    assert one.size == same.size
    assert one.problem.specification == same.problem.specification
    assert one.size != other.size


@pytest.mark.parametrize("number", [0, 1, 2])
def test_patches_turn_by_angles_in_their_range_between_the_flanks(number):
    scene = random_scene(5, number)
    features = contact_features(scene.problem, scene.size)
    assert features.keys() == FEATURES.keys()
    assert 0.9 * ANGLES[0] < features["angle"] < 1.1 * ANGLES[1]
    assert features["beyond"] > 0
    lower = scene.problem.bodies["lower"].contour
    touching = undeformed_surfaces(scene.problem).touching[0]
    middle = np.degrees(float(lower.inclination(touching)))
    # patches go further on the side of the smaller curvature
    assert abs(abs(middle) - features["middle"]) < 0.35 * features["angle"]


def test_features_do_not_depend_on_units_of_length_and_modulus():
    scene = random_scene(5, 1)
    step = saturation(scene.problem, scene.size, 0.3, 1000.0)
    assert saturation(scene.problem, scene.size, 0.6, 1000.0) == pytest.approx(2 * step)
    assert saturation(scene.problem, scene.size, 0.3, 500.0) == pytest.approx(step / 2)


@pytest.mark.slow  # C: a minute
@pytest.mark.parametrize("index", range(SOLVED_AGAIN))
def test_known_scenes_are_as_solved_again(index):
    known = packaged_knowledge().scenes[index]
    entry = solve_scene(random_scene(known.seed, known.number), known.seed, known.number)
    errors, estimates = ics_errors(entry), reference_estimates(entry)
    for ics, of_ics in known.errors.items():
        for number, error in of_ics.items():
            # stored with four digits; tractions of rolling to 1e-4
            allowed = estimates[number] + 1e-3 * (1 + abs(error))
            assert abs(errors[ics][number] - error) <= allowed, (ics, number)
