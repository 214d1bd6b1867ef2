"""The numbers of contacts that one may want of ICs, and the scale of which the error of each is a share.

A scale never decides silently: a number with two sensible scales has two names, such as `F_x` and
`F_x/limit`.
"""

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from difflib import get_close_matches
from typing import TYPE_CHECKING

from femic.contact.specification import ContactSpecification
from geometries.errors import WrongInput

if TYPE_CHECKING:
    from femic.scenes.scene import Scene

KNOWN = 10.0  # times its estimate: a number that may vanish is known as a share of itself from there on


@dataclass(frozen=True)
class Scale:
    """What errors are shares of, in words.

    `vanishing`: the number may vanish. Its errors are then known where it exceeds `KNOWN` estimates only.
    """

    meaning: str
    vanishing: bool = False


@dataclass(frozen=True)
class Want:
    """A number of a contact by its name in files of contacts, and the scale of its errors."""

    name: str
    number: str
    scale: Scale


ITSELF = Scale("share of the number itself")
ITSELF_WHERE_KNOWN = Scale(
    f"share of the number itself, where it exceeds {KNOWN:g} times the estimate of the reference", True
)
LIMIT = Scale("share of friction times load")
LOAD = Scale("share of the load")
HALF_WIDTH = Scale("share of b, the half-width of the patch")
WHOLE = Scale("difference as it is: of shares of the patch")
SATURATION = Scale("share of the creepage at which the slope at no force reaches friction times load")

_COMMON = tuple(Want(name, name, ITSELF) for name in ("p_max", "a", "b", "angle", "area", "approach"))
_SIDEWAYS = Want("F_y", "F_y", ITSELF_WHERE_KNOWN), Want("F_y/limit", "F_y", LIMIT)
_SLIDING = Want("sliding_share", "sliding_share", WHOLE)
WANTS: Mapping[str, tuple[Want, ...]] = {  # by motion
    "none": (
        *_COMMON,
        Want("aspect", "aspect", ITSELF),
        Want("stiffness", "stiffness", ITSELF),
        Want("load", "load", ITSELF),
        Want("F_y/load", "F_y", LOAD),
        Want("s_centre/b", "s_centre", HALF_WIDTH),
        Want("position/b", "position", HALF_WIDTH),
    ),
    "rolling": (
        Want("F_x", "F_x", ITSELF_WHERE_KNOWN),
        Want("F_x/limit", "F_x", LIMIT),
        *_SIDEWAYS,
        Want("dissipation", "dissipation", ITSELF_WHERE_KNOWN),
        _SLIDING,
        Want("zero_creepage", "zero_creepage", SATURATION),
        Want("slope", "slope", ITSELF),
        Want("equal_creepage", "equal_creepage", SATURATION),
        *_COMMON,
    ),
    "compression": (*_COMMON, *_SIDEWAYS, _SLIDING),
}


def wants_of(specification: ContactSpecification) -> tuple[Want, ...]:
    """Return the numbers of a contact that ICs change: without those that are prescribed.

    None of motions in which ICs are not compared, and without loads and approaches.
    """
    if not specification.loadings:
        return ()
    prescribed = _prescribed_numbers(specification)
    return tuple(want for want in WANTS.get(specification.motion, ()) if want.number not in prescribed)


def _prescribed_numbers(specification: ContactSpecification) -> set[str]:
    """Return the numbers that are the same with all ICs."""
    if specification.friction is not None:
        return set()
    sideways = "position" if specification.lateral_force is None else "F_y"
    return {"load" if specification.loads else "approach", sideways}


def default_names(specification: ContactSpecification) -> tuple[str, ...]:
    """Return what is wanted where nothing is named: p_max, and F_x of a contact in rolling."""
    names = [want.name for want in wants_of(specification)]
    return tuple(name for name in ("p_max", "F_x") if name in names)


def chosen_wants(specification: ContactSpecification, names: Sequence[str]) -> tuple[Want, ...]:
    """Return numbers of a contact by their names, each once; raise WrongInput for names that it has not."""
    known = {want.name: want for want in wants_of(specification)}
    if not known:
        raise WrongInput(f"want = {list(names)}: {_without_numbers(specification)}")
    for name in names:
        if name not in known:
            raise WrongInput(f"want = {name!r}: {_unknown(name, specification.motion, known)}")
    return tuple(known[name] for name in dict.fromkeys(names))


def want_misfits(scene: "Scene") -> Iterator[str]:
    """Yield why a scene's contact does not have what is wanted."""
    if scene.want:
        try:
            chosen_wants(scene.contact, scene.want)
        except WrongInput as refusal:
            yield str(refusal)


def _without_numbers(specification: ContactSpecification) -> str:
    if not specification.loadings:
        return "the scene has no contact: give [contact] loads = [...] in N, or approaches = [...] in mm"
    motions = " or ".join(map(repr, WANTS))
    return f"contact.motion = {specification.motion!r}: ICs are compared with motion = {motions}"


def _unknown(name: str, motion: str, known: Mapping[str, Want]) -> str:
    """Return why a contact has no such number, and which it has."""
    motions = [other for other, wants in WANTS.items() if name in [want.name for want in wants]]
    if motion in motions:
        reason = "prescribed by the scene"
    elif motions:
        reason = f"not of contact.motion = {motion!r}, but of {' or '.join(map(repr, motions))}"
    else:
        similar = get_close_matches(name, known, n=1)
        reason = f"no such number{f'; did you mean {similar[0]!r}?' if similar else ''}"
    return f"{reason}: one of {', '.join(known)}"
