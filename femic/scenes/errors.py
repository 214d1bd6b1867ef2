"""The exception for scenes that cannot be run."""

from collections.abc import Iterable

from geometries.errors import WrongInput


class BadScene(WrongInput):
    """A scene that cannot be run; the message lists every error with field, value and remedy."""


def bad_scene(name: object, errors: Iterable[str]) -> BadScene:
    """Return the exception that lists all errors of a scene or file."""
    lines = list(errors)
    return BadScene(f"{name}: {len(lines)} error(s)\n  " + "\n  ".join(lines))


def require_none(scene: object, misfits: Iterable[str]) -> None:
    """Raise BadScene with all misfits, each once, if there are any."""
    if lines := list(dict.fromkeys(misfits)):
        raise bad_scene(scene, lines)
