"""The terminal: a console that prints names such as Bhat+sn:B and [a] as they are."""

from typing import Any

from rich.console import Console


def terminal(**options: Any) -> Console:
    """Return a console with options of `rich.console.Console`: no part of a text is an emoji or a tag."""
    return Console(emoji=False, markup=False, highlight=False, **options)
