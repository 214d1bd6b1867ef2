"""Values of swept keys from text: cells of tables, and names of points such as flank=30,ratio=1.1."""

import re
from collections.abc import Iterator
from contextlib import suppress
from typing import Any

import numpy as np
import tomlkit
from tomlkit.exceptions import TOMLKitError
from tomlkit.items import AbstractTable, Array, Float, Integer

from femic.scenes.errors import BadScene
from geometries.profiles.standards import NAMED
from geometries.profiles.text import as_float

Value = bool | int | float | str | list[Any]

WHOLE = re.compile(r"[+-]?[0-9]+")
DECIMAL = re.compile(r"[+-]?([0-9]+\.?[0-9]*|\.[0-9]+)([eEdD][+-]?[0-9]+)?")  # D: of Fortran
LARGEST_WHOLE = 2**53  # beyond, floats do not have all whole numbers
SHOWN = 40  # characters of a text that messages show


def value_of(text: str) -> Value:
    """Return the value of a text as TOML has it: a number, true or false, a list; other text is text.

    Numbers are plain decimals, also .5, 05, 1. and 1.5D3; raises BadScene for others, such as 0x10, 1_2, nan.
    Names of profiles of the package are text: 60E1 is a rail.
    """
    text = text.strip()
    if text in NAMED:
        return text
    if DECIMAL.fullmatch(text):
        value = as_float(text)
        if not np.isfinite(value):
            raise BadScene(f"{text[:SHOWN]}: is too large for a number")
        return int(text) if WHOLE.fullmatch(text) and abs(value) <= LARGEST_WHOLE else value
    numbers, item = [], None
    with suppress(ValueError):
        float(text)  # Python takes it for a number
        numbers.append(text)
    if not numbers:
        with suppress(TOMLKitError, RecursionError):  # the latter of lists that lie thousands deep
            item = tomlkit.value(text)
        numbers += _numbers(item)
    for number in numbers:
        if not DECIMAL.fullmatch(number):
            raise BadScene(f"{number[:SHOWN]}: is not a finite decimal number; write one such as 16 or 1.5e3")
        value_of(number)  # raises for one that is too large
    plain = None if item is None else item.unwrap()
    return plain if isinstance(plain, bool | str | list) else text


def _numbers(item: object) -> Iterator[str]:
    """Yield the numbers in an item of TOML as they are written."""
    if isinstance(item, Integer | Float):
        yield item.as_string()
    elif isinstance(item, Array | AbstractTable):
        for part in item.values() if isinstance(item, AbstractTable) else item:
            yield from _numbers(part)
