"""Changes of built-in scenes, a few words each."""

import numpy as np


def arc(flanks, radius=10.0):
    return {"contour": {"kind": "arc", "radius": radius, "flank_inclination_deg": flanks}}


def ellipse(b, d):
    return {"contour": {"kind": "ellipse", "b_el": b, "d_el": d}}


def both(of_a_body):
    return {"lower": of_a_body, "upper": of_a_body}


def straight(left, right):
    """A plane through points, which ends at two places."""
    y = np.linspace(left, right, 9)
    return {"contour": {"kind": "points", "points": np.column_stack([y, 0 * y]).tolist()}}


def patch(a, b, s=0.0):
    return {"patch": {"a": a, "b": b, "s": s}}


def line(along, at, reach):
    """One line."""
    return {"lines": [{"along": along, ("s" if along == "x" else "x"): at, "reach": reach, "points": 11}]}


def engine(**keys):
    return {"engine": keys}


SHORT = line("x", 0.0, 3.0)
PROPERTY = {"effective": {"lower": {"nu": {"far": 0.3, "r_inf": 9.0, "m": 1.0, "n": 2.0}}}}
