"""What is checked: statements, and for each the numbers that decide it, with thresholds set beforehand.

Statements 1 to 13 are those of [BVSV], 14 and 15 are about this program. The table was written before its
first run; thresholds have not been changed since, and what was changed is listed in `CHANGES`. Where a number
misses its threshold, the report says so. Errors are those of `femic.accuracy`; "lines along x" and "the line
along s" are those of the scenes. Where scenes are compared, curves are dimensionless.
"""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Literal

FOLLOWS = 0.10  # largest error with which a curve still follows another
POOR = 0.20  # error from which on it is poor
SATISFACTORY = 0.05  # largest error that is fully satisfactory
SMALL_PART = 1 / 3
MUCH = 1 / 2
ROUNDING = 1e-12  # two routes to the same number
HALF_SPACE = 1e-9  # its far field against point loads, the first neglected term included


CLOSE = 0.002  # of the threshold (of 1, where it is 0): a number that C, known to 0.001, cannot decide

CHANGES = (
    "3, before the first run: differences instead of ratios, which mean nothing where a number is negative.",
    "6, after it: each line by itself; pooled, s = 0, where both bodies are alike, hid the other.",
    "9, after it: convex and concave in the sign of A. The source draws each body in its own frame, in which "
    "A_sn of both is alike; here it has opposite signs, and what deviates to opposite sides there lies on "
    "the same side, and adds, as statement 5 says.",
    "10, after it: each body alone; together the factor cancels where both are alike, so that it could not "
    "fail.",
    "15, after it: not the criterion but the program: an error 1.4 times its estimate was found, and "
    "estimates were made safer (CHANGELOG).",
)


@dataclass(frozen=True)
class Criterion:
    """A measured number and its threshold; it is met in a case (a geometry, a body) or it is not."""

    name: str
    says: str
    relation: Literal["<", ">"]
    threshold: float

    def met(self, value: float) -> bool:
        """Whether a measured value is on the right side; never where it is not a number."""
        return bool(value < self.threshold if self.relation == "<" else value > self.threshold)

    def close(self, value: float) -> bool:
        """Whether a value is so close to the threshold that the accuracy of C cannot decide."""
        return abs(value - self.threshold) <= CLOSE * (abs(self.threshold) or 1.0)


@dataclass(frozen=True)
class Statement:
    """Something that is said, and what decides it."""

    claim: str
    criteria: tuple[Criterion, ...]


STATEMENTS: Mapping[int, Statement] = {
    1: Statement(
        "B_nn follows C_nn laterally, A_nn does not; longitudinally all three agree (both bodies together).",
        (
            Criterion("B lateral", "error of B_nn on the line along s", "<", FOLLOWS),
            Criterion("A lateral", "error of A_nn on the line along s", ">", FOLLOWS),
            Criterion("A along x", "error of A_nn on the lines along x", "<", FOLLOWS),
            Criterion("B along x", "error of B_nn on the lines along x", "<", FOLLOWS),
        ),
    ),
    2: Statement(
        "The combined C_xx is about A_xx, alike in both geometries.",
        (
            Criterion("A", "error of A_xx on all lines", "<", FOLLOWS),
            Criterion(
                "alike", "largest difference of (C_xx - A_xx) / scale between geometries", "<", FOLLOWS
            ),
        ),
    ),
    3: Statement(
        "C_ss falls faster than B_ss along x, most on Geometry 2 and on its convex body.",
        (
            Criterion("faster", "1 - C_ss / B_ss at x = reference length, s = 0", ">", 0.0),
            Criterion("geometry", "the same of both bodies: Geometry 2 less Geometry 1", ">", 0.0),
            Criterion("convex", "the same on Geometry 2: convex body less concave body", ">", 0.0),
        ),
    ),
    4: Statement(
        "In xs the convex body deviates more from A than the concave one; B_xs is better than B̂_xs; neither "
        "is fully satisfactory.",
        (
            Criterion("convex", "error of A_xs: convex body over concave body", ">", 1.0),
            Criterion("better", "error of B_xs over that of B̂_xs", "<", 1.0),
            Criterion("left", "the smaller of both errors", ">", SATISFACTORY),
        ),
    ),
    5: Statement(
        "Deviations of the two bodies from A cancel in nn, ss, xx, xs and add in xn, sn.",
        (
            Criterion("cancel", "|sum of both deviations| / sum of their norms: nn, ss, xx, xs", "<", 0.5),
            Criterion("add", "the same: xn, sn", ">", 0.75),
        ),
    ),
    6: Statement(
        "B_xn is poor; B puts the larger displacement in the concave body, C in the convex one.",
        (
            Criterion("poor", "error of B_xn, both bodies together", ">", POOR),
            Criterion("in B", "rms of B_xn on a line along x: concave body over convex body", ">", 1.0),
            Criterion("in C", "rms of C_xn on a line along x: convex body over concave body", ">", 1.0),
        ),
    ),
    7: Statement(
        "B̂′_xn is close to C_xn along x, somewhat too large near the load, more so on Geometry 1.",
        (
            Criterion("close", "error of B̂′_xn on the lines along x", "<", FOLLOWS),
            Criterion("too large", "mean of (B̂′ - C) sgn C / max |C| within 0.3 reference lengths", ">", 0.0),
            Criterion("geometry", "the same: Geometry 1 less Geometry 2", ">", 0.0),
        ),
    ),
    8: Statement(
        "C_xn is larger on Geometry 2; longitudinal curvature explains a small part of it.",
        (
            Criterion("larger", "rms of C_xn on s = 0: Geometry 2 over Geometry 1", ">", 1.0),
            Criterion(
                "curvature",
                "part of the difference that is gone with a wheel that is not revolved",
                "<",
                SMALL_PART,
            ),
        ),
    ),
    9: Statement(
        "C_sn: convex body well below A, concave above; B_sn better than B̂_sn, B̂′_sn worst; much of C_sn - "
        "B̂_sn is a vertical translation; the largest misfit lies beyond the arc/flank joint of Geometry 1.",
        (
            Criterion(
                "convex", "mean of (C - A) sgn A / max |A| on the line along s, convex body", "<", -POOR
            ),
            Criterion("concave", "the same, concave body", ">", 0.0),
            Criterion("B", "error of B_sn over that of B̂_sn", "<", 1.0),
            Criterion("B̂′", "error of B̂′_sn over that of B̂_sn", ">", 1.0),
            Criterion(
                "translation", "part of |C_sn - B̂_sn|² that a vertical translation explains", ">", MUCH
            ),
            Criterion("flank", "|s| of the largest |C_sn - B̂_sn| over that of the joint", ">", 1.0),
        ),
    ),
    10: Statement(
        "The factor (π - |α|) / π on A_sn brings no consistent gain.",
        (
            Criterion(
                "gain",
                "share of cases (bodies alone) in which the error of sn falls by a tenth",
                "<",
                0.75,
            ),
        ),
    ),
    11: Statement(
        "ν = 0.28 or 0.30 makes no difference that matters.",
        (Criterion("change", "largest change of a component of C, as an error", "<", SATISFACTORY),),
    ),
    12: Statement(
        "The mix beats each single variant.",
        (
            Criterion("worst", "worst error of a component: mix over the best single variant", "<", 1.0),
            Criterion("mean", "mean error over the components: likewise", "<", 1.0),
        ),
    ),
    13: Statement(
        "Without a fit, A_xn is better than B_xn and B̂_xn.",
        (Criterion("A", "error of A_xn over the smaller one of B_xn and B̂_xn", "<", 1.0),),
    ),
    14: Statement(
        "Both engines agree within their estimates on every component, body and geometry.",
        (Criterion("apart", "largest |difference| / (sum of both estimates) of a component", "<", 1.0),),
    ),
    15: Statement(
        "Limits are met: the plane by every variant and by C, a nearly plane contour by C, point loads by A, "
        "the cylinder by B.",
        (
            Criterion("variants", "plane: largest error of a variant against A", "<", ROUNDING),
            Criterion("plane", "plane: largest |C - A| / estimate of C", "<", 1.0),
            Criterion("nearly plane", "arc of 1000 reference lengths: error of A against C", "<", 0.01),
            Criterion(
                "point loads", "A at 1e5 patches: relative deviation from point loads", "<", HALF_SPACE
            ),
            Criterion(
                "cylinder",
                "B of line loads with the factor (π - |α|) / π: relative deviation from cavity or cylinder",
                "<",
                ROUNDING,
            ),
        ),
    ),
}
