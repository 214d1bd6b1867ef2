"""Keys of scene files: those that name files, columns of numbers in these, and keys by dotted names.

Each key that names files declares it, and paths are absolute once they are read. Columns are points of
contours and of extra gaps, and are read as profiles are. Dotted names are such as lower.contour.radius and
lines.0.s.
"""

from collections.abc import Callable, Iterable, Iterator, Mapping, MutableMapping, Sequence
from dataclasses import dataclass, replace
from functools import cache
from pathlib import Path
from typing import Annotated, Any, TypeAlias, get_args

import numpy as np
from pydantic import BaseModel, FilePath, Strict

from femic.scenes.errors import BadScene
from geometries.arrays import Array
from geometries.profiles.text import number, read_source, split_columns, uncommented

# --- names of files -------------------------------------------------------------------------------------


@dataclass(frozen=True)
class NamesFile:
    """Declares that the values of a key name files: those that begin with `prefix`, behind it."""

    prefix: str = ""


@dataclass(frozen=True)
class Holds:
    """Declares the tables that a key may hold, where its type does not say it."""

    tables: Callable[[], Iterable[type[BaseModel]]]


Prefixes: TypeAlias = tuple[str, ...]
Tables: TypeAlias = tuple[type[BaseModel], ...]
ExistingFile = Annotated[FilePath, Strict(False), NamesFile()]


def make_files_absolute(
    table: MutableMapping[str, Any], keys: type[BaseModel], folder: Path = Path()
) -> None:
    """Replace names of files in a table, relative to a folder, by absolute paths."""
    replace_files(table, keys, lambda name: str((folder / name).resolve()))


def replace_files(table: MutableMapping[str, Any], keys: type[BaseModel], new: Callable[[str], str]) -> None:
    """Replace names of files in a table that has some of the `keys` of a model, and in the tables in it.

    What is of another type than declared stays for the validation to refuse.
    """
    for key, (prefixes, tables) in _declared_files(keys).items():
        if key in table:
            table[key] = _with_files(table[key], prefixes, tables, new)


def _with_files(value: Any, prefixes: Prefixes, tables: Tables, new: Callable[[str], str]) -> Any:
    """Return the value of a key with other names of files."""
    if isinstance(value, MutableMapping):
        for keys in tables:
            replace_files(value, keys, new)
    elif isinstance(value, list):
        for k, entry in enumerate(value):
            value[k] = _with_files(entry, prefixes, tables, new)
    elif isinstance(value, str):
        prefix = next((prefix for prefix in prefixes if value.startswith(prefix)), None)
        return value if prefix is None else prefix + new(value.removeprefix(prefix))
    return value


@cache
def _declared_files(keys: type[BaseModel]) -> Mapping[str, tuple[Prefixes, Tables]]:
    """Return the prefixes of files and the tables that the keys of a model declare, of those that do."""
    declared = {}
    for name, field in keys.model_fields.items():
        parts = [*_parts(field.annotation), *field.metadata]
        prefixes = tuple(part.prefix for part in parts if isinstance(part, NamesFile))
        tables = [part for part in parts if isinstance(part, type) and issubclass(part, BaseModel)]
        tables += [table for part in parts if isinstance(part, Holds) for table in part.tables()]
        if prefixes or tables:
            declared[field.alias or name] = prefixes, tuple(tables)
    return declared


def _parts(annotation: Any) -> Iterator[Any]:
    """Yield a type, the types in it, and what they are annotated with."""
    yield annotation
    for part in get_args(annotation):
        yield from _parts(part)


# --- columns of numbers ---------------------------------------------------------------------------------


def columns(path: Path, headings: Sequence[str]) -> Array:
    """Return lengths [mm] in columns of one of the headings, such as "y, z", shape (rows, columns).

    They are separated by blanks, commas or semicolons; # begins a comment. Raise WrongInput that names the
    line with anything else.
    """
    names = {len(heading.split(", ")): heading.split(", ") for heading in headings}
    source = replace(read_source(path), path=Path(path.name))  # the key is named with its folder
    rows = list[list[float]]()
    for line, text in enumerate(source.lines, 1):
        cells = split_columns(source, line, uncommented(text, "#"))
        if not cells:
            continue
        if len(cells) not in names or (rows and len(cells) != len(rows[0])):
            before = f", {len(rows[0])} before" if rows else ""
            raise source.wrong(line, f"{len(cells)} columns{before}; give {' or '.join(headings)}")
        pairs = zip(cells, names[len(cells)], strict=True)
        rows.append([number(source, line, cell, name) for cell, name in pairs])
    if not rows:
        raise source.refused(f"no numbers; give columns {' or '.join(headings)}")
    return np.array(rows)


# --- keys by dotted name --------------------------------------------------------------------------------


def set_key(table: Any, key: str, entry: Any, axis: str) -> None:
    """Set a key such as lower.contour.radius or lines.0.s of a table, for an axis; raise BadScene."""
    *path, last = key.split(".")
    for part in path:
        if isinstance(table, list):
            table = table[_index(table, part, key, axis)]
        else:
            table = table.setdefault(part, {})
        if not isinstance(table, (dict, list)):
            raise BadScene(f"sweep.{axis}: {key}: {part} is a value, not a table")
    if isinstance(table, list):
        table[_index(table, last, key, axis)] = entry
    else:
        table[last] = entry


def key_of(table: Any, key: str, axis: str) -> Any:
    """Return the value of a key such as lower.contour.radius of a table, for an axis; raise BadScene."""
    for part in key.split("."):
        if isinstance(table, list):
            table = table[_index(table, part, key, axis)]
        elif isinstance(table, Mapping) and part in table:
            table = table[part]
        else:
            raise BadScene(f"{key}: not in the scene, which has to give it: it is swept as {axis}")
    return table


def _index(entries: Sequence[Any], part: str, key: str, axis: str) -> int:
    if not (part.isdigit() and int(part) < len(entries)):
        raise BadScene(f"sweep.{axis}: {key}: {part}: a number from 0 to {len(entries) - 1} is needed there")
    return int(part)
