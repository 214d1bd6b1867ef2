"""The numbers of its contact that a scene may want of ICs: which there are, and which are chosen."""

from collections.abc import Iterator, Sequence
from difflib import get_close_matches

from femic.contact.motions import MOTIONS
from femic.contact.motions.motion import Want
from femic.contact.specification import ContactSpecification
from femic.scenes.scene import Scene
from geometries.errors import WrongInput


def wants_of(specification: ContactSpecification) -> tuple[Want, ...]:
    """Return the numbers of a contact that ICs change: without those that are prescribed.

    None of motions in which ICs are not compared, and without loads and approaches.
    """
    if not specification.loadings:
        return ()
    prescribed = set[str]()  # with friction other numbers are
    if specification.friction is None:
        sideways = "position" if specification.lateral_force is None else "F_y"
        prescribed = {"load" if specification.loads else "approach", sideways}
    return tuple(want for want in MOTIONS[specification.motion].wants if want.number not in prescribed)


def default_names(specification: ContactSpecification) -> tuple[str, ...]:
    """Return what is wanted where nothing is named: p_max, and F_x of a contact in rolling."""
    names = [want.name for want in wants_of(specification)]
    return tuple(name for name in ("p_max", "F_x") if name in names)


def chosen_wants(specification: ContactSpecification, names: Sequence[str]) -> tuple[Want, ...]:
    """Return numbers of a contact by their names, each once; raise WrongInput for names that it has not."""
    known, motion = {want.name: want for want in wants_of(specification)}, specification.motion
    if not specification.loadings:
        raise WrongInput(
            f"want = {list(names)}: the scene has no contact: give [contact] loads = [...] in N, or "
            "approaches = [...] in mm"
        )
    if not known:
        others = " or ".join(repr(name) for name, other in MOTIONS.items() if other.wants)
        raise WrongInput(
            f"want = {list(names)}: contact.motion = {motion!r}: ICs are compared with motion = {others}"
        )
    for name in names:
        if name in known:
            continue
        motions = [key for key, other in MOTIONS.items() if name in [want.name for want in other.wants]]
        if motion in motions:
            reason = "prescribed by the scene"
        elif motions:
            reason = f"not of contact.motion = {motion!r}, but of {' or '.join(map(repr, motions))}"
        else:
            similar = get_close_matches(name, known, n=1)
            reason = f"no such number{f'; did you mean {similar[0]!r}?' if similar else ''}"
        raise WrongInput(f"want = {name!r}: {reason}: one of {', '.join(known)}")
    return tuple(known[name] for name in dict.fromkeys(names))


def want_misfits(scene: Scene) -> Iterator[str]:
    """Yield why a scene's contact does not have what is wanted."""
    if scene.want:
        try:
            chosen_wants(scene.contact, scene.want)
        except WrongInput as refusal:
            yield str(refusal)
