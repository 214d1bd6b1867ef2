"""The terminal: a console that prints names such as Bhat+sn:B as they are."""

from typing import Any

from rich.console import Console


def terminal(**options: Any) -> Console:
    """Return a console with options of `rich.console.Console` that takes no part of a text for an emoji."""
    return Console(emoji=False, **options)
