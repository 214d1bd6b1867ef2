"""What public functions and classes take: their annotations are checked, and messages are made of them.

One mechanism for all of them, so that an annotation says what is allowed, and nothing else has to. Numbers
are finite, unless infinity is the default; texts and booleans are no numbers; a list has at least one entry,
unless an empty one is the default. What is missing or unknown among arguments is said by Python itself.
"""

import collections.abc
import math
import numbers
import os
from collections.abc import Callable, Mapping
from dataclasses import MISSING, fields
from functools import cache, wraps
from inspect import signature
from pathlib import Path
from types import NoneType, UnionType
from typing import Any, Literal, ParamSpec, TypeVar, Union, get_args, get_origin, get_type_hints

import numpy as np
from numpy.typing import ArrayLike

from geometries.errors import WrongInput

Arguments = ParamSpec("Arguments")
Result = TypeVar("Result")
_type_hints = cache(get_type_hints)

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
    known = signature(function)
    parameters = known.parameters

    @wraps(function)
    def call(*arguments: Arguments.args, **named: Arguments.kwargs) -> Result:
        try:
            bound = known.bind(*arguments, **named).arguments
        except TypeError:
            return function(*arguments, **named)  # raises with the function's name
        _check({name: (value, parameters[name].default) for name, value in bound.items()}, function)
        return function(*arguments, **named)

    return call


def check_fields(noun: Any) -> None:
    """Raise WrongInput for fields of a dataclass that their annotations do not allow."""
    given = {field.name: (getattr(noun, field.name), field.default) for field in fields(noun) if field.init}
    _check(given, type(noun))


def _check(given: Mapping[str, tuple[Any, Any]], annotated: Any) -> None:
    """Raise WrongInput for the first value, beside its default, that the annotations do not allow."""
    allowed = _type_hints(annotated)
    for name, (value, default) in given.items():
        if name not in allowed or value is default:
            continue
        if text := find_misfit(name, value, allowed[name], default):
            raise WrongInput(text)


def find_misfit(name: str, value: Any, allowed: Any, default: Any = MISSING) -> str:
    """Return why a value is not of an allowed type, "" for one that is; `default` widens what is allowed."""
    inner = ""
    for option in _options(allowed):
        reason = _misfit(name, value, option, default)
        if reason is None:
            return ""
        inner = inner or reason
    return inner or f"{name} = {shown(value)}: give {_words(allowed)}"


def _options(allowed: Any) -> tuple[Any, ...]:
    """Return the types of a union; numbers of any shape count as one."""
    if get_origin(allowed) not in (Union, UnionType):
        return (allowed,)
    options = get_args(allowed)
    if frozenset(options) >= ARRAY:
        return (ArrayLike, *(option for option in options if option not in ARRAY))
    return options


def _misfit(name: str, value: Any, allowed: Any, default: Any) -> str | None:
    """Return why a value is not of an allowed type, "" without a reason of its own; None for one that is.

    Numbers of NumPy are those of Python.
    """
    origin, kinds = get_origin(allowed), get_args(allowed)
    if allowed is ArrayLike:
        try:
            array(name, value)
        except WrongInput as error:
            return str(error)
        return None
    if origin in (tuple, collections.abc.Sequence):
        is_array = isinstance(value, np.ndarray) and value.ndim > 0
        is_list = is_array or isinstance(value, list | tuple | range)
        if not is_list or (origin is tuple and len(value) != len(kinds)):
            return ""
        if not len(value) and default != ():
            return f"{name} = {shown(value)}: give at least one entry"
        entries = enumerate(zip(value, kinds if origin is tuple else kinds * len(value), strict=True))
        texts = (find_misfit(f"{name}[{k}]", entry, kind) for k, (entry, kind) in entries)
        return next(filter(None, texts), None)
    if origin is collections.abc.Mapping:
        if not isinstance(value, Mapping):
            return ""
        texts = (
            find_misfit(f"a key of {name}", key, kinds[0]) or find_misfit(f"{name}[{key!r}]", entry, kinds[1])
            for key, entry in value.items()
        )
        return next(filter(None, texts), None)
    if allowed is float and _is_number(value):
        try:
            number = float(value)
        except OverflowError:
            number = math.inf
        fits = math.isfinite(number) or number == default
        return None if fits else f"{name} = {shown(value)}: give a finite number"
    if origin is Literal:
        fits = isinstance(value, str) and value in kinds
    elif origin is collections.abc.Callable:
        fits = callable(value)
    elif allowed is int:
        fits = isinstance(value, numbers.Integral) and _is_number(value)
    elif allowed is bool:
        fits = isinstance(value, bool | np.bool_)
    else:
        fits = allowed is Any or (isinstance(allowed, type) and isinstance(value, allowed))
    return None if fits else ""


def _words(allowed: Any) -> str:
    """Return an allowed type in words."""
    options = _options(allowed)
    if len(options) > 1:
        return " or ".join(dict.fromkeys(map(_words, options)))
    (allowed,) = options
    origin, inner = get_origin(allowed), get_args(allowed)
    if origin is Literal:
        return " or ".join(map(repr, inner))
    if origin is tuple:
        return f"{len(inner)} values in brackets, each {_words(inner[0])}"
    if origin is collections.abc.Sequence:
        return f"a list, each entry {_words(inner[0])}"
    if origin is collections.abc.Mapping:
        return "a mapping (dict)"
    if origin is collections.abc.Callable:
        return "a function, such as print"
    if allowed in WORDS:
        return WORDS[allowed]
    name, package = allowed.__name__, allowed.__module__.partition(".")[0]
    if name in MADE_BY:
        return f"what is made with {MADE_BY[name]}"
    if package in {"femic", "geometries"}:
        return f"a femic.{name}"
    return f"{'an' if package.startswith('x') else 'a'} {package}.{name}"


def array(name: str, value: Any) -> np.ndarray:
    """Return numbers as an array; raise WrongInput for what has others, for gaps, and for labelled ones.

    Masked numbers are none.
    """
    is_table = hasattr(value, "dims") and getattr(value, "ndim", 0) > 1  # an array of xarray
    if (columns := getattr(value, "columns", None)) is not None or is_table:
        what = f" with columns {', '.join(map(str, columns))}" if columns is not None else ""
        raise WrongInput(
            f"{name}: {_class(value)}{what}: labels are not read here; put the numbers in the documented "
            "order and give them as .to_numpy()"
        )
    if np.ma.isMaskedArray(value):
        value = np.ma.filled(value.astype(float), np.nan)
    try:
        values = np.asarray(value)
    except ValueError as error:
        raise WrongInput(
            f"{name}: rows have unequal lengths; give each row the same number of entries"
        ) from error
    except TypeError as error:
        raise WrongInput(f"{name} = {shown(value)}: give {NUMBERS}") from error
    if not values.size:
        raise WrongInput(f"{name} = {shown(value)}: give at least one number")
    if values.dtype.kind not in "iuf":
        for at, entry in np.ndenumerate(values):
            if not _is_number(entry):
                raise WrongInput(f"{name}{_index(at)} = {shown(entry)}: give {NUMBERS}")
    try:
        values = values.astype(float)
    except OverflowError as error:
        raise WrongInput(f"{name}: {error}: give finite numbers") from error
    for place in np.argwhere(~np.isfinite(values)):
        raise WrongInput(f"{name}{_index(place)} = {values[tuple(place)]}: give finite numbers")
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
    own = value.item() if isinstance(value, np.generic) else value
    try:
        text = str(own) if isinstance(own, os.PathLike) else repr(own)
    except ValueError:  # a whole number of thousands of digits
        return _class(value)
    return text if len(text) <= LONGEST else f"{text[: LONGEST - 1]}…"


def _is_number(value: Any) -> bool:
    if isinstance(value, np.ndarray) and not value.ndim:
        value = value[()]
    return isinstance(value, numbers.Real) and not isinstance(value, bool | np.bool_)


def _class(value: Any) -> str:
    name = type(value).__name__
    return f"{'an' if name[0] in 'AEIOUaeiou' else 'a'} {name}"


def _index(at: Any) -> str:
    return f"[{', '.join(str(int(k)) for k in at)}]" if len(at) else ""
