"""The error of a scene that cannot be run."""

from collections.abc import Iterable

from geometries.errors import WrongInput


class BadScene(WrongInput):
    """A scene that cannot be run; the message lists every error with field, value and remedy."""


def require_none(scene: object, misfits: Iterable[str]) -> None:
    """Raise BadScene if there are any misfits, with all of them."""
    found = list(misfits)
    if found:
        raise BadScene(f"{scene}: {len(found)} error(s)\n  " + "\n  ".join(found))
