"""The error of a scene that cannot be run."""

from collections.abc import Iterable

from geometries.errors import WrongInput


class BadScene(WrongInput):
    """A scene that cannot be run; the message lists every error with field, value and remedy."""


def require_none(scene: object, misfits: Iterable[str]) -> None:
    """Raise BadScene with all misfits, if there are any."""
    lines = list(misfits)
    if lines:
        raise BadScene(f"{scene}: {len(lines)} error(s)\n  " + "\n  ".join(lines))
