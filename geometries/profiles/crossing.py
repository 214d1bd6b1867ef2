"""Whether a polyline crosses or touches itself: boxes about runs of segments, halved level by level."""

import numpy as np

from geometries.arrays import Array, Indices, Mask

PAIRS_PER_SEGMENT = 8  # of boxes that overlap on one level; a contour has about 3
PAIRS_LOOKED_AT = 20_000  # where there are more


class Entangled(Exception):
    """More boxes overlap than can be looked at, and no crossing was found among the first of them."""


def first_crossing(points: Array) -> tuple[int, int] | None:
    """Numbers of two segments of a polyline (2, n) that meet without being neighbours, or None.

    Segment k joins the points k and k + 1. The polyline is in a binary tree of bounding boxes; pairs
    of boxes that overlap are halved until single segments are left. For a contour without crossings this
    takes O(n log n). Raises Entangled where too many boxes overlap.
    """
    boxes = _tree(points)
    most = PAIRS_PER_SEGMENT * points.shape[1] + 1000
    complete = True
    a, b = np.array([0]), np.array([0])
    for level in boxes[1:]:
        a, b = _halved(a, b, level)
        if len(a) > most:
            complete = False
            a, b = a[:PAIRS_LOOKED_AT], b[:PAIRS_LOOKED_AT]
    apart = b - a > 1
    a, b = a[apart], b[apart]
    meeting = np.flatnonzero(_meet(points, a, b))
    if len(meeting):
        k = meeting[np.lexsort([b[meeting], a[meeting]])[0]]
        return int(a[k]), int(b[k])
    if not complete:
        raise Entangled
    return None


def _tree(points: Array) -> list[Array]:
    """Boxes (least y, least z, largest y, largest z) of runs of segments, root first, each (4, m)."""
    low = np.minimum(points[:, :-1], points[:, 1:])
    high = np.maximum(points[:, :-1], points[:, 1:])
    levels = [np.concatenate([low, high])]
    while levels[-1].shape[1] > 1:
        boxes = levels[-1]
        if boxes.shape[1] % 2:
            boxes = np.concatenate([boxes, boxes[:, -1:]], axis=1)
            # a copy of the last box keeps the tree whole; _halved leaves it out
        low = np.minimum(boxes[:2, ::2], boxes[:2, 1::2])
        high = np.maximum(boxes[2:, ::2], boxes[2:, 1::2])
        levels.append(np.concatenate([low, high]))
    return levels[::-1]


def _halved(a: Indices, b: Indices, boxes: Array) -> tuple[Indices, Indices]:
    """Pairs a <= b of overlapping boxes of the next level, out of pairs of this one."""
    a, b = (
        np.concatenate([2 * a, 2 * a, 2 * a + 1, 2 * a + 1]),
        np.concatenate([2 * b, 2 * b + 1, 2 * b, 2 * b + 1]),
    )
    valid = (a <= b) & (b < boxes.shape[1])
    a, b = a[valid], b[valid]
    overlap = np.all((boxes[:2, a] <= boxes[2:, b]) & (boxes[:2, b] <= boxes[2:, a]), axis=0)
    return a[overlap], b[overlap]


def _meet(points: Array, a: Indices, b: Indices) -> Mask:
    """Whether segments a and b, whose boxes overlap, have a point in common, (m,)."""
    p, q, r, s = points[:, a], points[:, a + 1], points[:, b], points[:, b + 1]
    across = _side(p, q, r) * _side(p, q, s) <= 0
    return across & (_side(r, s, p) * _side(r, s, q) <= 0)


def _side(p: Array, q: Array, r: Array) -> Array:
    """Sign of the side of the line from p to q on which r lies, (m,)."""
    return np.sign((q[0] - p[0]) * (r[1] - p[1]) - (q[1] - p[1]) * (r[0] - p[0]))
