"""What public functions and classes take: their annotations are checked, and messages are made of them.

One mechanism for all of them, so that an annotation says what is allowed, and nothing else has to. Numbers
are finite, unless infinity is the default; texts and booleans are no numbers; a list has at least one entry,
unless an empty one is the default. What is missing or unknown among arguments is said by Python itself.
"""

import collections.abc
import math
import numbers
import os
from collections.abc import Callable, Iterator, Mapping
from dataclasses import MISSING, fields
from functools import cache, wraps
from inspect import signature
from pathlib import Path
from types import NoneType, UnionType
from typing import (
    TYPE_CHECKING,
    Any,
    Literal,
    ParamSpec,
    TypeVar,
    Union,
    get_args,
    get_origin,
    get_type_hints,
)

import numpy as np
from numpy.typing import ArrayLike

from geometries.errors import WrongInput

if TYPE_CHECKING:
    from _typeshed import DataclassInstance

Arguments = ParamSpec("Arguments")
Result = TypeVar("Result")

LONGEST = 60  # characters of a value in a message
ARRAY = frozenset(get_args(ArrayLike))
NUMBERS = "numbers: an array, a list, or one number"
WORDS: dict[Any, str] = {
    ArrayLike: NUMBERS,
    float: "a number",
    int: "a whole number",
    bool: "True or False",
    str: "text",
    NoneType: "None",
}
SHOWN = (numbers.Number, np.bool_, str, bytes, list, tuple, set, dict, NoneType, os.PathLike)  # in messages
MADE_BY = {  # classes that are not public, by their names
    "SceneTable": "arc, ellipse, plane, through_points or Profile.at",
    "Scene": "load_scene",
    "EffectiveProperties": "fit_bhat_prime, as effective of its pair",
    "LineAlongX": "line_along_x",
    "LineAlongS": "line_along_s",
    "OffsetLine": "points",
}


def with_checked_arguments(function: Callable[Arguments, Result]) -> Callable[Arguments, Result]:
    """Return a public function that raises WrongInput for arguments that its annotations do not allow."""

    @wraps(function)
    def call(*arguments: Arguments.args, **named: Arguments.kwargs) -> Result:
        try:
            bound = signature(function).bind(*arguments, **named).arguments
        except TypeError:
            return function(*arguments, **named)  # raises with the function's name
        allowed, parameters = _hints(function), signature(function).parameters
        _require(
            text
            for name, value in bound.items()
            if name in allowed and value is not parameters[name].default
            for text in misfits(name, value, allowed[name], parameters[name].default)
        )
        return function(*arguments, **named)

    return call


def check_fields(noun: "DataclassInstance") -> None:
    """Raise WrongInput for fields of a dataclass that their annotations do not allow."""
    allowed = _hints(type(noun))
    given = {field.name: field.default for field in fields(noun) if field.init}
    _require(
        text
        for name, default in given.items()
        if (value := getattr(noun, name)) is not default
        for text in misfits(name, value, allowed[name], default)
    )


def misfits(name: str, value: Any, allowed: Any, default: Any = MISSING) -> Iterator[str]:
    """Yield why a value is not of an allowed type; `default` widens what is allowed."""
    options = _options(allowed)
    found = [_misfit(name, value, option, default) for option in options]
    if any(text is None for text in found):
        return
    inner = next(filter(None, found), None)
    yield inner or f"{name} = {shown(value)}: give {_any_of(allowed)}"


def array(name: str, value: Any) -> np.ndarray:
    """Return numbers as an array; raise WrongInput for what has others, for gaps, and for labelled ones.

    Masked numbers are none.
    """
    if (columns := getattr(value, "columns", None)) is not None or (_is_labelled(value) and value.ndim > 1):
        what = f" with columns {', '.join(map(str, columns))}" if columns is not None else ""
        raise WrongInput(
            f"{name}: {_class(value)}{what}: its labels are not read: put the numbers in the order that the "
            "documentation says, and give them as .to_numpy()"
        )
    if np.ma.isMaskedArray(value):
        value = np.ma.filled(value.astype(float), np.nan)
    try:
        values = np.asarray(value)
    except ValueError as error:
        raise WrongInput(f"{name}: rows of unequal length: give each the same number of entries") from error
    except TypeError as error:
        raise WrongInput(f"{name} = {shown(value)}: give {NUMBERS}") from error
    if not values.size:
        raise WrongInput(f"{name} = {shown(value)}: give at least one number")
    if values.dtype.kind not in "iuf":
        _require(
            f"{name}{_index(at)} = {shown(entry)}: give {NUMBERS}"
            for at, entry in np.ndenumerate(values)
            if not _is_number(entry)
        )
    try:
        values = values.astype(float)
    except OverflowError as error:
        raise WrongInput(f"{name}: {error}: give finite numbers") from error
    for at in np.argwhere(~np.isfinite(values)):
        raise WrongInput(f"{name}{_index(at)} = {values[tuple(at)]}: give finite numbers")
    return values


def new_file(path: str | Path) -> Path:
    """Return the path of a file to be written; raise WrongInput where no file can be."""
    path, fault = Path(path), ""
    try:
        if path.is_dir():
            fault = "is a folder: give the name of a file"
        elif not path.parent.is_dir():
            fault = f"no folder {path.parent}: make it"
        else:
            path.lstat()
    except FileNotFoundError:
        pass
    except (OSError, ValueError) as error:  # names that are too long or have a null character
        fault = f"{getattr(error, 'strerror', None) or error}: give another name"
    if fault:
        raise WrongInput(f"path = {shown(str(path))}: {fault}")
    return path


def shown(value: Any) -> str:
    """Return a value as messages show it: short ones as Python writes them, others by their class."""
    if isinstance(value, np.ndarray) and value.ndim:
        return f"array of shape {value.shape}"
    if isinstance(value, type):
        return f"the class {value.__name__}"
    if not isinstance(value, SHOWN):
        return _class(value)
    try:
        text = (
            str(value)
            if isinstance(value, os.PathLike)
            else repr(value.item() if isinstance(value, np.generic) else value)
        )
    except ValueError:  # a whole number of thousands of digits
        return _class(value)
    return text if len(text) <= LONGEST else f"{text[: LONGEST - 1]}…"


def _require(texts: Iterator[str]) -> None:
    """Raise WrongInput with the first text, if there is one."""
    for text in texts:
        raise WrongInput(text)


@cache
def _hints(annotated: Any) -> dict[str, Any]:
    return {name: hint for name, hint in get_type_hints(annotated).items() if name != "return"}


def _options(allowed: Any) -> tuple[Any, ...]:
    """Return the types of a union; numbers of any shape count as one."""
    if get_origin(allowed) not in (Union, UnionType):
        return (allowed,)
    options = get_args(allowed)
    if frozenset(options) >= ARRAY:
        return (ArrayLike, *(option for option in options if option not in ARRAY))
    return options


def _misfit(name: str, value: Any, allowed: Any, default: Any) -> str | None:
    """Return why a value is not of an allowed type, "" without a reason of its own; None for one that is."""
    origin = get_origin(allowed)
    if allowed is ArrayLike:
        return _text(lambda: array(name, value))
    if origin is tuple or origin is collections.abc.Sequence:
        return _misfit_of_list(name, value, allowed, default)
    if origin is collections.abc.Mapping:
        return _misfit_of_mapping(name, value, get_args(allowed))
    if allowed is float and _is_number(value):
        return _misfit_of_number(name, value, default)
    return None if _is_a(value, allowed) else ""


def _misfit_of_number(name: str, value: Any, default: Any) -> str | None:
    try:
        number = float(value)
    except OverflowError:
        number = math.inf
    if math.isfinite(number) or number == default:
        return None
    return f"{name} = {shown(value)}: give a finite number"


def _misfit_of_list(name: str, value: Any, allowed: Any, default: Any) -> str | None:
    kinds = get_args(allowed)
    length = len(kinds) if get_origin(allowed) is tuple else None
    if not _is_list(value) or length not in (None, len(value)):
        return ""
    if not len(value) and default != ():
        return f"{name} = {shown(value)}: give at least one entry"
    entries = zip(value, kinds if length else kinds * len(value), strict=True)
    for k, (entry, kind) in enumerate(entries):
        for text in misfits(f"{name}[{k}]", entry, kind):
            return text
    return None


def _misfit_of_mapping(name: str, value: Any, kinds: tuple[Any, Any]) -> str | None:
    if not isinstance(value, Mapping):
        return ""
    for key, entry in value.items():
        for text in (
            *misfits(f"a key of {name}", key, kinds[0]),
            *misfits(f"{name}[{key!r}]", entry, kinds[1]),
        ):
            return text
    return None


def _is_a(value: Any, allowed: Any) -> bool:
    """Whether a value is of a class, or one of several; numbers of NumPy are those of Python."""
    if allowed is Any:
        return True
    if get_origin(allowed) is Literal:
        return isinstance(value, str) and value in get_args(allowed)
    if get_origin(allowed) is collections.abc.Callable:
        return callable(value)
    if allowed is int:
        return isinstance(value, numbers.Integral) and _is_number(value)
    if allowed is bool:
        return isinstance(value, bool | np.bool_)
    return isinstance(allowed, type) and isinstance(value, allowed)


def _is_number(value: Any) -> bool:
    if isinstance(value, np.ndarray) and not value.ndim:
        value = value[()]
    return isinstance(value, numbers.Real) and not isinstance(value, bool | np.bool_)


def _is_list(value: Any) -> bool:
    return isinstance(value, list | tuple | range) or (isinstance(value, np.ndarray) and value.ndim > 0)


def _is_labelled(value: Any) -> bool:
    """Whether a value is an array of xarray."""
    return hasattr(value, "dims") and hasattr(value, "ndim")


def _words(allowed: Any) -> str:
    """Return an allowed type in words."""
    origin, inner = get_origin(allowed), get_args(allowed)
    if origin is Literal:
        return " or ".join(map(repr, inner))
    if origin is tuple:
        return f"{len(inner)} values in brackets, each {_any_of(inner[0])}"
    if origin is collections.abc.Sequence:
        return f"a list, each entry {_any_of(inner[0])}"
    if origin is collections.abc.Mapping:
        return "a mapping (dict)"
    if origin is collections.abc.Callable:
        return "a function, such as print"
    return WORDS.get(allowed) or _words_of_class(allowed)


def _any_of(allowed: Any) -> str:
    return " or ".join(dict.fromkeys(_words(option) for option in _options(allowed)))


def _words_of_class(allowed: type) -> str:
    if allowed.__name__ in MADE_BY:
        return f"what is made with {MADE_BY[allowed.__name__]}"
    if allowed.__module__.partition(".")[0] in {"femic", "geometries"}:
        return f"a femic.{allowed.__name__}"
    place = f"{allowed.__module__.partition('.')[0]}.{allowed.__name__}"
    return f"{'an' if place.startswith('x') else 'a'} {place}"


def _class(value: Any) -> str:
    name = type(value).__name__
    return f"{'an' if name[0] in 'AEIOUaeiou' else 'a'} {name}"


def _index(at: Any) -> str:
    return f"[{', '.join(str(int(k)) for k in at)}]" if len(at) else ""


def _text(check: Callable[[], object]) -> str | None:
    """Return the message of a check that raises WrongInput."""
    try:
        check()
    except WrongInput as error:
        return str(error)
    return None
