"""Errors on which a user can act: wrong input, and results that could not be computed."""

import sys
from collections.abc import Collection
from numbers import Integral, Number, Real
from typing import Any


class WrongInput(ValueError):
    """The input cannot be used; the message names the field, the value and the remedy."""


def require_numbers(noun: Any, *, whole: Collection[str] = ()) -> None:
    """Raise WrongInput for fields of a dataclass that are no numbers, or no whole ones."""
    for name, value in vars(noun).items():
        kind = Integral if name in whole else Real
        if not isinstance(value, kind) or isinstance(value, bool):
            shown = repr(value) if isinstance(value, Number | str | bytes | None) else type(value).__name__
            raise WrongInput(f"{name} = {shown}: give a {'whole ' if name in whole else ''}number")
        if isinstance(value, int) and name not in whole and abs(value) > sys.float_info.max:
            raise WrongInput(f"{name} = {str(value)[:20]}...: give a finite number")


class Failure(RuntimeError):
    """The result could not be computed; the message gives the numbers and what to try."""
