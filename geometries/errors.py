"""Errors on which a user can act: wrong input, and results that could not be computed."""

import sys
from dataclasses import fields
from numbers import Integral, Real
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from _typeshed import DataclassInstance


class WrongInput(ValueError):
    """An input that cannot be used; the message names the field, the value and the remedy."""


class Failure(RuntimeError):
    """A result that could not be computed; the message gives the numbers and what to try."""


def require_numbers(noun: "DataclassInstance") -> None:
    """Raise WrongInput for fields of a dataclass that are no numbers; those declared as `int` are whole."""
    for field in fields(noun):
        value, whole = getattr(noun, field.name), field.type is int
        if isinstance(value, bool) or not isinstance(value, Integral if whole else Real):
            kind = "a whole number" if whole else "a number"
            raise WrongInput(f"{field.name} = {value!r:.60}: give {kind}")
        if isinstance(value, Integral) and abs(int(value)) > sys.float_info.max:
            raise WrongInput(f"{field.name}: more than {sys.float_info.max:.0e}: give a smaller number")
