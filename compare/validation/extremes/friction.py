"""Contact with friction at its limits: steady rolling, and contacts that depend on the way to them.

Elastically similar half-spaces against Kalker's coefficients where nothing slips, strips of Carter where a
patch is short along x, Coulomb's law where all slides; others against finer elements, or against themselves
mirrored or in other units.

Compression of bodies of like materials against the contact without friction, of unlike ones against full
stick, rolling from rest against steady rolling; others against finer elements.
"""

from dataclasses import replace
from typing import Any

import numpy as np

from compare.validation.extremes.cases import FRICTION, Limit
from compare.validation.extremes.contacts import (
    BeyondContact,
    Cases,
    ContactCase,
    Solver,
    Truth,
    base_scene,
    bumps,
    conformal,
    contact_limits,
    crossed,
    finer,
    same_as,
    two_bumps,
)
from compare.validation.extremes.engines import Changes
from compare.validation.extremes.friction_solutions import (
    CARTER,
    FULL_STICK,
    KALKER,
    NO_FRICTION,
    SLIDING,
    TURNING,
    TWO_OF_KALKER,
    compress,
    roll,
    roll_from_rest,
)

LOAD = 100.0  # N, of the rollers
STICKS, SLIDES = 1000.0, 0.3  # friction with which nothing slips; usual one
SMALL = 1e-4  # creepage at which rollers are far from sliding
LEAST = -0.999  # creepage that is named first, since a curve has two, and not solved
STEPS = 6  # of a load that grows
PRESSED = ("approach", "p_max", "sliding_share", "area")
ROLLED = ("F_x", "F_y", "M_z", "dissipation", "sliding_share", "p_max", "approach")
FINER = finer(*ROLLED)


# --- scenes ----------------------------------------------------------------------------------------------


def rolls(xi: float = SMALL, friction: float = SLIDES, **contact: Any) -> dict[str, Any]:
    """Return keys of a contact that rolls at a creepage."""
    return {"motion": "rolling", "friction": [friction], "longitudinal": [LEAST, xi], **contact}


def rollers(xi: float = SMALL, friction: float = SLIDES, load: float = LOAD, **keys: Any) -> Changes:
    """Return changes of `flat`: a roller that rolls on a crown; further keys of bodies or of the contact."""
    bodies = {key: keys.pop(key) for key in ("crown", "roller", "bodies") if key in keys}
    return crossed(load, **bodies, **rolls(xi, friction, **keys))


def case(label: str, changes: Changes, truth: Truth, solve: Solver = roll) -> ContactCase:
    """Return a case of rollers, or of conformal bodies."""
    return ContactCase(label, base_scene(changes), changes, solve, truth)


def beyond(label: str, changes: Changes) -> BeyondContact:
    """Return a case beyond the limits of rolling."""
    return BeyondContact(label, base_scene(changes), changes, roll)


def embraced(
    xi: float, *, friction: float = SLIDES, ratio: float = 0.01, load: float = 1e3, **keys: Any
) -> Changes:
    """Return changes of `geometry1`: a wheel with a groove that rolls on the arc of a rail."""
    bodies = {key: keys.pop(key) for key in ("flanks", "roller") if key in keys}
    return conformal(load, ratio, **bodies, **rolls(xi, friction, elements=8, **keys))


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


def _invariances() -> list[ContactCase]:
    """Return contacts that must be others times a factor: in other units, and mirrored."""
    unit = 1e4
    creeps = {"lateral": 2e-4}
    large = rollers(
        5e-4, load=LOAD * unit**2, crown=300.0 * unit, roller=500.0 * unit, spin=1e-4 / unit, **creeps
    )
    small = case("", rollers(5e-4, spin=1e-4, **creeps), FINER)
    powers = {"F_x": 2, "F_y": 2, "M_z": 3, "dissipation": 2, "sliding_share": 0, "p_max": 0, "approach": 1}
    in_mm = same_as("the same in mm", small, {name: unit**power for name, power in powers.items()})
    here, there = (
        embraced(5e-4, ratio=0.02, flanks=flanks, shift=sign * 0.1, lateral=sign * 2e-4, spin=sign * 1e-4)
        for flanks, sign in (([60.0, 45.0], 1), ([45.0, 60.0], -1))
    )
    factors = {**dict.fromkeys(ROLLED, 1.0), "F_y": -1.0, "M_z": -1.0}
    mirrored = same_as("its mirror image", case("", there, FINER), factors)
    return [
        case(f"lengths times {unit:g}", large, in_mm),
        case("away from the crown, with spin", here, mirrored),
    ]


# --- limits ----------------------------------------------------------------------------------------------


def limits() -> list[Limit]:
    """Return the limits of contact with friction, with cases within and beyond them."""
    circle, short = {"crown": 500.0, "roller": 500.0}, {"crown": 1e5, "roller": 100.0}
    stiff = {"lower": {"nu": 0.0}, "upper": {"nu": 0.0}}
    alike = {"lower": {"nu": 0.4999}, "upper": {"nu": 0.4999, "E": 2.1e3}}
    unlike = _pressed_on_circle(STICKS, {"E": 2.1e3, "nu": 0.0})
    from_rest: Changes = {"motion": "transient", "friction": [SLIDES], "creepage": 1e-3, "elements": 12}
    steady = Truth("steady, elements 1/4", FINER.numbers)
    table: dict[tuple[str, str], Cases] = {
        ("friction", "> 0 … 1000"): [
            case("1e-9", rollers(friction=1e-9), NO_FRICTION),
            case("0.3, some slips", rollers(1.5e-4), FINER),
            case("10", rollers(friction=10.0), KALKER),
            case("1000", rollers(friction=STICKS), KALKER),
            case("10, conformal", embraced(5e-4, friction=10.0), FINER),
            beyond("0", rollers(friction=0.0)),
            beyond("1001", rollers(friction=1001.0)),
        ],
        ("creepage", "-1 … 1"): [
            # on curved bodies F_x is that of a creepage of 1e-8 at none, which Kalker's plane theory has not
            case("1e-9", rollers(1e-9), FINER),
            case("0.99", rollers(0.99), SLIDING),
            case("-0.99", rollers(-0.99), SLIDING),
            case("0.99, conformal", embraced(0.99), FINER),
            beyond("1", rollers(1.0)),
        ],
        ("lateral creepage", "-1 … 1"): [
            case("1e-4", rollers(0.0, STICKS, lateral=SMALL), KALKER),
            case("0.99, creepage 0.5", rollers(0.5, lateral=0.99), SLIDING),
            beyond("1", rollers(lateral=1.0)),
        ],
        ("spin", "-1 … 1 /mm"): [
            case("1e-4 /mm", rollers(0.0, STICKS, spin=SMALL), KALKER),
            case("1e-3 /mm, much slips", rollers(0.0, spin=1e-3), FINER),
            case("1 /mm", rollers(0.0, spin=1.0, **circle), TURNING),
            beyond("1.1 /mm", rollers(spin=1.1)),
        ],
        ("modulus ratio", "0.01 … 100"): [
            case(f"{ratio:g}", rollers(1e-3, elements=12, bodies={"upper": {"E": 210e3 * ratio}}), FINER)
            for ratio in (0.01, 100.0)
        ],
        ("ν", "0 … 0.4999"): [
            case("ν = 0", rollers(0.0, STICKS, lateral=SMALL, bodies=stiff), KALKER),
            case("ν = 0.4999, modulus ratio 0.01", rollers(SMALL, STICKS, bodies=alike), KALKER),
        ],
        ("R_roll", "20 … 1e6 mm"): [
            case("20 mm", rollers(friction=STICKS, load=10.0, roller=20.0), KALKER),
            case("1e6 mm", rollers(friction=STICKS, crown=1e6, roller=1e6), KALKER),
            case("20 mm, conformal", embraced(2e-3, load=300.0, roller=20.0), FINER),
            beyond("∞", rollers(roller=np.inf)),
        ],
        ("R_w / R_r − 1", "> 0"): [
            case("0.0001", embraced(2e-5, ratio=1e-4, load=10.0), FINER),
            case("9", embraced(2e-5, ratio=9.0, load=10.0), FINER),
            case("9, all slides", embraced(5e-4, ratio=9.0, load=10.0), FINER),
            beyond("0", embraced(5e-4, ratio=0.0)),
        ],
        ("patch aspect a/b", "any"): [
            case("1/68, some slips", rollers(1e-4, **short), CARTER),
            case("1/68, nothing slips", rollers(1e-5, STICKS, **short), CARTER),
            case("18", rollers(friction=STICKS, crown=20.0, roller=2e3), KALKER),
        ],
        ("elements across", "8 … 64"): [
            case(str(count), rollers(friction=STICKS, elements=count), KALKER) for count in (8, 64)
        ],
        # side by side, where nothing slips: each bears half of the forces
        ("patches", "1, 2, …"): [
            replace(case("2, far apart", bumps(**rolls(friction=STICKS)), TWO_OF_KALKER), gap=two_bumps())
        ],
        ("compression", "friction 0 … 1000"): [
            case("like bodies", _pressed_on_circle(0.3, {}), NO_FRICTION, compress),
            case("modulus ratio 0.01, ν = 0, friction 1000", unlike, FULL_STICK, compress),
            case("conformal", _compression(0.3), finer(*PRESSED, factor=2), compress),
            case("conformal, friction 10", _compression(10.0), finer(*PRESSED, factor=2), compress),
        ],
        ("rolling from rest", "any distance"): [
            case("three patches", crossed(LOAD, **from_rest), steady, roll_from_rest),
            BeyondContact("1 km", "flat", crossed(LOAD, distance=1e6, **from_rest), roll_from_rest),
        ],
        ("units, sides", "any"): _invariances(),
    }
    return contact_limits(FRICTION, table)
