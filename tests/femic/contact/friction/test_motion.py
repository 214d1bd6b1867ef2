"""Motions: slip against its definition and smooth fields, kinematics of a rigid wheel, leading edges."""

from dataclasses import replace
from itertools import groupby, product

import numpy as np
import pytest

from femic.contact.friction.motion import (
    DEPTH,
    LEAST_PER_DEPTH,
    NAMES,
    Creepages,
    FreeSlip,
    LeadingEdge,
    Motion,
    RollingKinematics,
    RollingStep,
    Shift,
    SteadyRolling,
    centred,
    centred_derivative,
    growing,
)
from femic.contact.patch import Box, block_mean
from geometries.contours import arc, plane
from geometries.errors import WrongInput

RANDOM = np.random.default_rng(0)
U, W, BEFORE = RANDOM.normal(size=(3, 8, 6, 2))
DX = 0.3


def test_slip_of_a_shift_is_the_shift_plus_the_growth_of_displacements():
    result = Shift(W, before=BEFORE)
    np.testing.assert_allclose(result.elastic_slip(U) + result.given, W + U - BEFORE)
    np.testing.assert_allclose(Shift(W).elastic_slip(U) + Shift(W).given, W + U)
    np.testing.assert_array_equal(result.at_elements(U), U)
    assert result.depth == 0


def test_a_vertical_approach_shifts_by_its_component_along_s():
    """Down by d, over the tangent (cos, -sin) in (y, z): d sin along s."""
    delta = np.linspace(-0.5, 0.7, 6)
    shift = Shift(W, before=BEFORE, per_approach=np.sin(delta), approach_before=0.02)
    added = shift.given_at(0.05) - shift.given
    for column in range(6):
        along_s = np.array([0.0, -0.03]) @ [np.cos(delta[column]), -np.sin(delta[column])]
        np.testing.assert_allclose(added[:, column], np.tile([0.0, along_s], (8, 1)), atol=1e-15)
    from_none = Shift(W, per_approach=np.sin(delta))
    np.testing.assert_allclose(from_none.given_at(0.03) - W, added, atol=1e-15)
    np.testing.assert_array_equal(Shift(W).given_at(3.0), W)


@pytest.mark.parametrize("order", [1, 2])
def test_rolling_takes_displacements_from_the_next_element_ahead(order):
    """Steady rolling those of now, a step of it those before."""
    steady, step = SteadyRolling(W, dx=DX, order=order), RollingStep(W, dx=DX, order=order, before=BEFORE)
    for motion, ahead in ((steady, U), (step, BEFORE)):
        result = motion.elastic_slip(U) + motion.given
        for row, column in np.ndindex(7, 6):
            w = W[row, column] if order == 1 else (W[row, column] + W[row + 1, column]) / 2
            expected = w + (U[row, column] - ahead[row + 1, column]) / DX
            np.testing.assert_allclose(result[row, column], expected)
    assert steady.depth == (0 if order == 1 else DEPTH)
    first = RollingStep(W, dx=DX, order=order)
    np.testing.assert_allclose(step.given - first.given, -np.r_[BEFORE[1:], BEFORE[-1:]] / DX)
    np.testing.assert_allclose(step.elastic_slip(U), first.elastic_slip(U))


@pytest.mark.parametrize("order", [1, 2])
def test_slip_has_the_error_of_its_order(order):
    """Between elements and at them, of smooth fields whose directions turn; ends of the grid do not count."""
    phases, errors = np.array([0.0, 0.6]), []

    def exact(x):
        return np.cos(0.4 * x + phases) - 0.7 * np.cos(0.7 * x + phases)

    for n in (40, 80):
        dx = 2.0 / n
        x = dx * np.arange(n)[:, None, None] + 0 * phases
        motion = SteadyRolling(np.cos(0.4 * x + phases), dx=dx, order=order)
        slip = motion.elastic_slip(np.sin(0.7 * x + phases)) + motion.given
        between = (slip - exact(x if order == 1 else x + dx / 2))[:-1]
        at_elements = (motion.at_elements(slip) - exact(x))[1:-1]
        errors.append([np.max(np.abs(between)), np.max(np.abs(at_elements))])
    np.testing.assert_allclose(np.log2(np.divide(*errors)), order, atol=0.1)


BOX = Box((2, 7), (1, 4))


@pytest.mark.parametrize(
    "motion",
    [
        Motion(W),
        Shift(W, before=BEFORE, per_approach=W[0, :, 0], approach_before=0.1),
        SteadyRolling(W, (FreeSlip(BEFORE, RANDOM.normal(size=(8, 6, 3)), 2.0),), dx=DX),
        SteadyRolling(W, dx=DX, order=1),
        RollingStep(W, dx=DX, before=BEFORE),
        RollingStep(W, dx=DX),
    ],
    ids=["motion", "shift", "with a free slip", "order 1", "step", "step from nothing"],
)
def test_in_a_box_slip_is_that_of_its_elements(motion):
    """But for its last row, which has no neighbour ahead."""
    part = motion.within(BOX)
    for here, there in (
        (part.elastic_slip(BOX.crop(U)), motion.elastic_slip(U)),
        (part.given_at(0.3), motion.given_at(0.3)),
        *zip(part.free_slips, motion.free_slips, strict=True),
    ):
        np.testing.assert_allclose(here[:-1], BOX.crop(there)[:-1], rtol=1e-12)
    for here, there in zip(part.free, motion.free, strict=True):
        np.testing.assert_array_equal(here.weights, BOX.crop(there.weights))
        assert here.force == there.force
    assert (type(part), part.depth) == (type(motion), motion.depth)


def test_free_slips_are_taken_where_rigid_ones_are():
    free = FreeSlip(W, RANDOM.normal(size=(8, 6, 3)), 3.0)
    for order in (1, 2):
        motion = SteadyRolling(0 * W, (free,), dx=DX, order=order)
        np.testing.assert_array_equal(motion.free_slips[0], SteadyRolling(W, dx=DX, order=order).given)
    for motion, number in product((Motion(W), SteadyRolling(W, dx=DX, order=1)), range(3)):
        several = replace(motion, free=(free,) * number).free_slips
        np.testing.assert_array_equal(several, np.broadcast_to(W, (number, *W.shape)), strict=True)


@pytest.mark.parametrize("motion", [Motion(W), SteadyRolling(W, dx=DX, order=1), SteadyRolling(W, dx=DX)])
def test_derivative_of_the_slip_at_elements_agrees_with_differences(motion):
    change = 1e-6 * BEFORE
    difference = motion.at_elements(U + change) - motion.at_elements(U - change)
    np.testing.assert_allclose(motion.derivative_at_elements(U)(change), difference / 2, atol=1e-12)


def test_simpler_forms_of_rolling_have_one_follower_less_each():
    motion, depths = SteadyRolling(W, dx=DX, followers=3), []
    while motion is not None and len(depths) < 9:
        depths.append(motion.depth)
        motion = motion.simpler
    assert depths == [3, 2, 1, 0]
    for simplest in (SteadyRolling(W, dx=DX, order=1), Shift(W)):
        assert simplest.simpler is None


def fine(coarse):
    return coarse.repeat(2, axis=0).repeat(2, axis=1)


def test_on_coarser_elements_fields_are_means_and_forces_stay():
    coarse = RANDOM.normal(size=(4, 3, 2))
    np.testing.assert_allclose(block_mean(fine(coarse)), coarse)
    np.testing.assert_allclose(block_mean(W)[1, 2], W[2:4, 4:6].mean(axis=(0, 1)))
    weights, p = RANDOM.normal(size=(8, 6, 3)), RANDOM.normal(size=(4, 3, 3))
    rolling = SteadyRolling(W, (FreeSlip(W, weights, 3.0),), dx=DX, order=1).coarsened()
    assert np.sum(rolling.free[0].weights * p) == pytest.approx(np.sum(weights * fine(p)))
    assert rolling.free[0].force == 3.0
    assert (rolling.dx, rolling.order) == (2 * DX, 1)
    np.testing.assert_array_equal(rolling.rigid, block_mean(W))
    np.testing.assert_array_equal(rolling.free_slips[0], block_mean(W))
    sines = RANDOM.normal(size=6)
    shift = Shift(W, before=BEFORE, per_approach=sines, approach_before=0.1).coarsened()
    np.testing.assert_allclose(
        shift.given_at(0.4)[1, 2], block_mean(W - BEFORE)[1, 2] + [0, 0.15 * sum(sines[4:])]
    )
    assert Shift(W).coarsened().before is None
    assert [motion.has_coarser for motion in (Shift, SteadyRolling, RollingStep)] == [True, True, False]


@pytest.mark.parametrize("order", [0, 3, 1.5])
def test_other_orders_are_refused(order):
    with pytest.raises(WrongInput, match=f"order = {order}: 1 or 2"):
        SteadyRolling(W, dx=DX, order=order)


# ---- slip at the centres of elements: the mean where smooth, nothing only where there is none, continuous


def pairs(n=400, seed=0):
    """Slips of two elements in rows, the second of which is looked at, over 12 decades of ratios."""
    random = np.random.default_rng(seed)
    slip = random.normal(size=(2, n, 2))
    slip[0] *= 10.0 ** random.uniform(-6, 6, (n, 1))
    return slip


def test_centred_slip_vanishes_only_with_the_slip_ahead():
    slip = pairs()
    result = np.linalg.norm(centred(slip)[1], axis=-1)
    assert np.all(result > 0.49 * np.linalg.norm(slip[1], axis=-1))
    slip[1] = 0
    np.testing.assert_array_equal(centred(slip)[1], 0)
    slip[0] = 0
    np.testing.assert_array_equal(centred(slip), 0)


def test_centred_slip_is_the_slip_ahead_where_the_one_behind_vanishes_or_opposes():
    slip = pairs()
    stuck, opposed = slip.copy(), slip.copy()
    stuck[0] *= 1e-12 / np.linalg.norm(slip[0], axis=-1, keepdims=True)
    opposed[0] *= -np.sign(np.sum(slip[0] * slip[1], axis=-1, keepdims=True))
    np.testing.assert_allclose(centred(stuck)[1], slip[1], rtol=1e-9, atol=1e-9)
    np.testing.assert_array_equal(centred(opposed)[1], slip[1])


def test_centred_slip_grows_with_the_slips():
    slip = pairs()
    np.testing.assert_allclose(centred(3.0 * slip), 3.0 * centred(slip), rtol=1e-12)


def test_derivative_agrees_with_differences():
    slip, change = pairs(seed=1), np.random.default_rng(2).normal(size=(2, 400, 2))
    change *= 1e-6 * np.linalg.norm(slip, axis=-1, keepdims=True)
    difference = (centred(slip + change) - centred(slip - change)) / 2
    np.testing.assert_allclose(
        centred_derivative(slip)(change), difference, rtol=1e-5, atol=1e-9 * np.max(np.abs(difference[1]))
    )


# ---- leading edges against plain loops over runs of elements in contact


def runs(column):
    """(first, last) elements of all runs with bounds."""
    for positive, places in groupby(range(len(column)), lambda place: column[place] > 0):
        numbers = list(places)
        if positive:
            yield numbers[0], numbers[-1]


def followed_by_loops(bound, depth):
    followed = np.repeat(np.arange(len(bound))[:, None], bound.shape[1], axis=1)
    for column in range(bound.shape[1]):
        for first, last in runs(bound[:, column]):
            following = min(depth, (last - first + 1) // LEAST_PER_DEPTH)
            for place in range(last - following + 1, last + 1):
                followed[place, column] = last - following
    return followed


def many_runs(seed):
    """Bounds in rows with runs of all lengths, some of them at the ends of the grid."""
    random = np.random.default_rng(seed)
    bound = random.uniform(0.5, 2.0, (60, 12))
    bound[random.random(bound.shape) < 0.08] = 0.0
    bound[:, 0], bound[:, 1] = 0.0, 1.0
    return bound


@pytest.mark.parametrize("depth", [0, 1, 2, 3])
@pytest.mark.parametrize("seed", range(3))
def test_the_last_elements_of_each_run_follow_the_one_behind_them(seed, depth):
    bound = many_runs(seed)
    lengths = {last - first + 1 for column in bound.T for first, last in runs(column)}
    assert {1, 2, 3, 6, 7, 60} <= lengths
    assert any(2 * LEAST_PER_DEPTH <= length < 60 for length in lengths)
    given = bound.copy()
    edge = LeadingEdge.find(given, depth)
    np.testing.assert_array_equal(given, bound)
    expected = followed_by_loops(bound, depth)
    np.testing.assert_array_equal(edge.followed, expected)
    follows = expected != np.arange(60)[:, None]
    assert np.any(follows) == (depth > 0)
    np.testing.assert_array_equal(edge.free, (bound > 0) & ~follows)
    rows, columns = np.nonzero(bound)
    of_followed = bound[edge.followed[rows, columns], columns]
    np.testing.assert_allclose(edge.ratio[rows, columns], bound[rows, columns] / of_followed)
    assert np.all(edge.ratio[bound == 0] == 0)


@pytest.mark.parametrize(("length", "following"), [(1, 0), (5, 0), (6, 1), (11, 1), (12, 2), (40, 2)])
def test_in_short_runs_fewer_elements_follow(length, following):
    bound = np.zeros((length + 5, 1))
    bound[2 : 2 + length] = 1.0
    moved = np.arange(length + 5) - LeadingEdge.find(bound).followed[:, 0]
    expected = np.zeros(length + 5)
    expected[2 + length - following : 2 + length] = np.arange(1, following + 1)
    np.testing.assert_array_equal(moved, expected)


def test_tractions_take_the_same_share_of_their_bounds():
    bound = many_runs(4)
    edge, p = LeadingEdge.find(bound, 2), np.random.default_rng(0).normal(size=(*bound.shape, 2))
    spread = edge.spread(p)
    np.testing.assert_array_equal(spread[edge.free], p[edge.free])
    assert np.all(spread[bound == 0] == 0)
    following = np.argwhere((bound > 0) & ~edge.free)
    assert len(following) > 10
    for row, column in following:
        behind = edge.followed[row, column], column
        np.testing.assert_allclose(spread[row, column], spread[behind] / bound[behind] * bound[row, column])
    assert not np.any(LeadingEdge.find(np.zeros((4, 3)), 2).free)


# ---- rigid velocities against those of a rigid wheel that turns about its axle, in three dimensions

CONTOUR, RADIUS, SPEED = arc(10.0, 1.2, 0.9), 460.0, 3.0
X_AT, S_AT = np.linspace(-6.0, 5.0, 7), np.linspace(-11.0, 8.0, 9)
HEIGHT = CONTOUR.position(S_AT)[1] - 0.8 + 0.05 * S_AT  # of another contour, that of the wheel
ROLLING = RollingKinematics(CONTOUR, RADIUS, X_AT, S_AT, HEIGHT)
CASES = [
    Creepages(),
    Creepages(2e-3),
    Creepages(lateral=-3e-3),
    Creepages(spin=1e-4),
    Creepages(-0.3, 0.2, 0.05),
]


def of_a_rigid_wheel(creepages, x, s, height):
    """Velocity over the rail along x, s, n per unit of rolled distance, one point at a time.

    In axes that move with the contact the rail runs back with the speed V, and the wheel turns about an axle
    at the height R_roll over its crown. Turning about y so that the lowest point runs back is omega > 0.
    """
    y, _ = CONTOUR.position(s)
    tangent_y, tangent_z = CONTOUR.tangent(s)
    omega = (1 + creepages.longitudinal) * SPEED / RADIUS
    about_axle = np.cross([0.0, omega, 0.0], [x, y, height - RADIUS])
    about_z = np.cross([0.0, 0.0, creepages.spin * SPEED], [x, y, height])
    aside = np.array([0.0, creepages.lateral * SPEED, 0.0])
    rail = np.array([-SPEED, 0.0, 0.0])
    over_rail = (about_axle + about_z + aside - rail) / SPEED
    along_x, along_s = np.array([1.0, 0.0, 0.0]), np.array([0.0, tangent_y, tangent_z])
    return [over_rail @ direction for direction in (along_x, along_s, np.cross(along_x, along_s))]


@pytest.mark.parametrize("creepages", CASES, ids=str)
def test_rigid_velocity_is_that_of_a_rotating_wheel(creepages):
    expected = np.array(
        [[of_a_rigid_wheel(creepages, x, *at) for at in zip(S_AT, HEIGHT, strict=True)] for x in X_AT]
    )
    np.testing.assert_allclose(ROLLING.rigid_velocity(creepages), expected, rtol=1e-12, atol=1e-15)
    np.testing.assert_array_equal(ROLLING.rigid_slip(creepages), ROLLING.rigid_velocity(creepages)[..., :2])


def test_each_creepage_adds_its_own_slip():
    result = ROLLING.rigid_slip(Creepages())
    for name, value in zip(NAMES, (-2e-3, 5e-3, 3e-4), strict=True):
        result = result + value * ROLLING.per_creepage(name)
    np.testing.assert_allclose(result, ROLLING.rigid_slip(Creepages(-2e-3, 5e-3, 3e-4)), atol=1e-16)


def test_a_plane_on_a_plane_only_slides_and_turns():
    flat = RollingKinematics(plane(), np.inf, X_AT, S_AT, 0 * S_AT)
    assert np.all(flat.rigid_velocity(Creepages()) == 0)
    slip = flat.rigid_slip(Creepages(1e-3, 2e-3, 1e-4))
    np.testing.assert_allclose(slip[..., 0], np.broadcast_to(-1e-3 - 1e-4 * S_AT, (7, 9)))
    np.testing.assert_allclose(slip[..., 1], np.broadcast_to(2e-3 + 1e-4 * X_AT[:, None], (7, 9)))


@pytest.mark.parametrize("name", NAMES)
@pytest.mark.parametrize("value", [np.nan, np.inf])
def test_creepages_must_be_numbers(name, value):
    with pytest.raises(WrongInput, match=f"{name}=.*: must be finite"):
        Creepages(**{name: value})


def test_pairs_of_friction_by_angle_must_grow():
    pairs = ((20.0, 1.0), (40.0, 0.3))
    assert growing(pairs) == pairs
    with pytest.raises(ValueError, match="angle 20 comes after 40: angles must increase"):
        growing(pairs[::-1])
    with pytest.raises(ValueError, match="angle 20 comes after 20"):
        growing((pairs[0], pairs[0]))
    with pytest.raises(ValueError, match="all factors are 0"):
        growing(((20.0, 0.0),))
