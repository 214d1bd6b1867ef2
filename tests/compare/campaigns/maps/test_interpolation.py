"""Interpolation between nodes: exact for cubic functions, of fourth order, with an error that is larger."""

import numpy as np
import pytest

from compare.campaigns.interpolation import KINK, AxisNodes, interpolate
from geometries.errors import WrongInput

PLACES = (0.0, 1.0, 2.5, 3.0, 5.0, 6.0)
AXIS = AxisNodes("flank", PLACES)


def along(nodes, f, value):
    stencil = nodes.at(value)
    return float(interpolate(f(np.array(nodes.values)[stencil.nodes]), [stencil]))


def error(nodes, f, value):
    """The largest error on left-out nodes near a value, as it counts."""
    values = f(np.array(nodes.values))
    return KINK * max(
        abs(float(interpolate(values[stencil.nodes], [stencil])) - values[node])
        for node, stencil in nodes.left_out(value)
    )


@pytest.mark.parametrize("value", [0.3, 1.7, 2.9, 4.0, 5.9])
def test_cubic_functions_are_exact_and_any_function_at_nodes(value):
    cubic = np.poly1d([-0.5, 3, -2, 1])
    assert along(AXIS, cubic, value) == pytest.approx(cubic(value), rel=1e-12)
    assert error(AXIS, cubic, value) < 1e-12
    for node in PLACES:
        assert along(AXIS, np.exp, node) == np.exp(node)


def test_logarithmic_axes_are_exact_for_powers_of_the_logarithm():
    nodes = AxisNodes("E", (1.0, 2.0, 5.0, 10.0, 30.0), spacing="logarithmic")
    assert along(nodes, lambda x: np.log(x) ** 3, 7.0) == pytest.approx(np.log(7.0) ** 3)
    assert along(AxisNodes("E", nodes.values), np.log, 7.0) != pytest.approx(np.log(7.0), rel=1e-4)


@pytest.mark.parametrize(("count", "order"), [(3, 2.6), (9, 3.7)])
def test_order_of_convergence(count, order):
    """Half as far apart, errors of sin are 2^order times smaller; with three nodes near 2 only."""

    def worst(n):
        nodes = AxisNodes("x", tuple(np.linspace(0, 1.5, n)))
        middles = (np.array(nodes.values)[1:] + np.array(nodes.values)[:-1]) / 2
        return max(abs(along(nodes, np.sin, value) - np.sin(value)) for value in middles)

    assert np.log2(worst(count) / worst(2 * count - 1)) > order


@pytest.mark.parametrize("f", [np.sin, np.exp, lambda x: 1 / (1 + x)], ids=["sin", "exp", "1/(1+x)"])
def test_error_at_left_out_nodes_bounds_the_error_between_nodes(f):
    nodes = AxisNodes("x", tuple(np.linspace(0, 2, 9)))
    for value in np.linspace(0.01, 1.99, 41):
        measured = error(nodes, f, value)
        assert abs(along(nodes, f, value) - f(value)) <= measured


def test_kink_half_way_between_nodes_has_the_estimated_error():
    """And with any other place of the kink or the value it errs less."""
    nodes = AxisNodes("x", tuple(np.arange(8.0)))
    middle = along(nodes, lambda x: np.abs(x - 3.5), 3.5)
    assert middle == pytest.approx(error(nodes, lambda x: np.abs(x - 3.5), 3.5))
    places = np.linspace(2.02, 4.98, 38)
    for kink in places:
        for value in places:

            def f(x, kink=kink):
                return np.abs(x - kink)

            assert abs(along(nodes, f, value) - f(value)) <= (1 + 1e-9) * error(nodes, f, value)


def random_function(random, *, kink):
    """A function of two variables, perhaps with a kink in the first one that moves with the other."""
    if not kink:
        of_x, of_y = (np.poly1d(random.normal(size=size)) for size in (5, 4))
        return lambda x, y: of_x(x) * of_y(y) + np.sin(2 * x * y)
    a, w, phase = random.normal(size=3), random.uniform(0.5, 3, 3), random.uniform(0, 6, 2)
    size = random.normal() * 10 ** random.uniform(-1.5, 1)
    at, moves = random.random(), random.uniform(-0.6, 0.6)

    def f(x, y):
        smooth = a[0] * np.sin(w[0] * x + phase[0]) + a[1] * np.exp(w[1] * x * y / 3)
        return smooth + a[2] * x * np.cos(w[2] * y + phase[1]) + size * np.abs(x - at - moves * (y - 0.5))

    return f


@pytest.mark.parametrize("kink", [False, True], ids=["smooth", "kink"])
def test_estimates_hold_at_95_percent_of_random_places(kink):
    """Of 400 random functions of two variables, on nodes at random distances."""
    random, held = np.random.default_rng(7), []
    for _ in range(400):
        steps = [np.cumsum(random.uniform(0.6, 1.4, random.integers(3, 8))) for _ in range(2)]
        axes = [AxisNodes(name, tuple((v - v[0]) / np.ptp(v))) for name, v in zip("xy", steps, strict=True)]
        f, point = random_function(random, kink=kink), random.random(2)
        actual = abs(at(axes, f, [axis.at(v) for axis, v in zip(axes, point, strict=True)]) - f(*point))
        held.append(actual <= estimated_error(axes, f, point))
    assert np.mean(held) >= 0.95


def at(axes, f, stencils):
    nodes = [np.array(axis.values)[stencil.nodes] for axis, stencil in zip(axes, stencils, strict=True)]
    return float(interpolate(f(*np.meshgrid(*nodes, indexing="ij")), stencils))


def estimated_error(axes, f, point):
    """The estimate of `CMap`, written for two axes."""
    (x, y), (of_x, of_y) = axes, point
    along_x = [
        abs(at(axes, f, [others, beside]) - at(axes, f, [x.single(node), beside]))
        for node, others in x.left_out(of_x)
        for beside in y.neighbours(of_y)
    ]
    along_y = [
        abs(at(axes, f, [beside, others]) - at(axes, f, [beside, y.single(node)]))
        for node, others in y.left_out(of_y)
        for beside in x.neighbours(of_x)
    ]
    return KINK * (max(along_x) + max(along_y))


def test_left_out_nodes_are_inner_neighbours_and_not_in_their_stencils():
    for value, expected in ((0.3, {1, 2, 3}), (1.7, {1, 2, 3}), (5.5, {2, 3, 4}), (2.5, {1, 2, 3})):
        left_out = AXIS.left_out(value)
        assert {node for node, _ in left_out} == expected
        assert all(node not in stencil.nodes for node, stencil in left_out)


def test_axes_are_combined_one_after_the_other():
    first, second = AxisNodes("a", (0.0, 1.0, 2.0, 3.0)), AxisNodes("b", (1.0, 2.0, 4.0, 5.0))
    stencils = [first.at(1.2), second.at(3.3)]
    x, y = (np.array(n.values)[s.nodes] for n, s in zip((first, second), stencils, strict=True))
    values = (x[:, None] ** 2 * y**3)[..., None] * np.array([1.0, -2.0])
    np.testing.assert_allclose(interpolate(values, stencils), 1.2**2 * 3.3**3 * np.array([1.0, -2.0]))


@pytest.mark.parametrize(
    ("values", "spacing", "message"),
    [
        *(
            (values, "linear", r"axis flank, \d values: a map needs 3 or more that increase")
            for values in ((1.0, 2.0), (1.0, 3.0, 2.0), (1.0, 1.0, 2.0))
        ),
        ((0.0, 1.0, 2.0), "logarithmic", "all positive"),
    ],
)
def test_axes_without_nodes_for_a_map_are_refused(values, spacing, message):
    with pytest.raises(WrongInput, match=message):
        AxisNodes("flank", values, spacing=spacing)


@pytest.mark.parametrize("value", [-0.1, 6.1, np.nan])
def test_nothing_is_extrapolated(value):
    with pytest.raises(WrongInput, match=r"flank = .*: outside the map, 0 \.\.\. 6"):
        AXIS.at(value)
