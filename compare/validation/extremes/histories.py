"""Contacts that depend on the way to them, at their limits: compression, and rolling from rest.

Bodies of like materials against the contact without friction, unlike ones against full stick, rolling from
rest against steady rolling; others against finer elements.
"""

from typing import Any

from compare.validation.extremes.bodies import base_of, conformal, crossed
from compare.validation.extremes.contacts import (
    BeyondContact,
    ContactCase,
    ContactLimit,
    ContactSolution,
    Solver,
    Truth,
    finer,
)
from compare.validation.extremes.engines import Changes
from compare.validation.extremes.friction_forms import FULL_STICK, NO_FRICTION, compress, roll_from_rest
from compare.validation.extremes.rolling import LOAD, ROLLED, SLIDES, STICKS

PRESSED = ("approach", "p_max", "sliding_share", "area")
STEPS = 6  # of a load that grows


def limits() -> list[ContactLimit]:
    """Return the limits of compression and of rolling from rest, with cases within and beyond them."""
    alike = _pressed_on_circle(0.3, {})
    unlike = _pressed_on_circle(STICKS, {"E": 2.1e3, "nu": 0.0})
    from_rest: dict[str, Any] = {
        "motion": "transient",
        "friction": [SLIDES],
        "creepage": 1e-3,
        "elements": 12,
    }
    return [
        ContactLimit(
            "compression",
            "friction 0 … 1000",
            [
                _case("like bodies", alike, NO_FRICTION, compress),
                _case(
                    "modulus ratio 0.01, ν = 0, friction 1000",
                    unlike,
                    FULL_STICK,
                    compress,
                ),
                _case("conformal", _compression(0.3), finer(*PRESSED, factor=2), compress),
                _case("conformal, friction 10", _compression(10.0), finer(*PRESSED, factor=2), compress),
            ],
        ),
        ContactLimit(
            "rolling from rest",
            "any distance",
            [
                _case(
                    "three patches",
                    crossed(LOAD, **from_rest),
                    Truth("steady, elements 1/4", _steady),
                    roll_from_rest,
                ),
            ],
            [BeyondContact("1 km", "flat", crossed(LOAD, distance=1e6, **from_rest), roll_from_rest)],
        ),
    ]


def _case(label: str, changes: Changes, truth: Truth, solve: Solver) -> ContactCase:
    return ContactCase(label, base_of(changes), changes, solve, truth)


def _compression(friction: float) -> Changes:
    """Return a wheel with a groove that is pressed on the arc of a rail in steps."""
    pressing: dict[str, Any] = {"motion": "compression", "friction": [friction], "elements": 8}
    changes = conformal(1e3, 0.01, **pressing)
    return {**changes, "contact": {**changes["contact"], "loads": _growing(1e3)}}


def _pressed_on_circle(friction: float, upper: Changes) -> Changes:
    """Return a circular contact that is pressed together in steps; changes of the upper body."""
    pressing: dict[str, Any] = {"motion": "compression", "friction": [friction]}
    changes = crossed(LOAD, crown=500.0, roller=500.0, bodies={"upper": upper}, **pressing)
    return {**changes, "contact": {**changes["contact"], "loads": _growing(LOAD)}}


def _growing(load: float) -> list[float]:
    """Return loads at which the radius of a contact of Hertz grows in equal steps."""
    return [load * ((number + 1) / STEPS) ** 3 for number in range(STEPS)]


def _steady(solved: ContactSolution) -> dict[str, float]:
    """Return the numbers of steady rolling on smaller elements."""
    numbers = solved.finer()
    return {name: numbers[name] for name in ROLLED}
