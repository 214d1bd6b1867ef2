"""Files that scene files name: each such key declares it, and paths are absolute once they are read."""

from collections.abc import Callable, Iterable, Iterator, Mapping, MutableMapping
from dataclasses import dataclass
from functools import cache
from pathlib import Path
from typing import Annotated, Any, TypeAlias, get_args

from pydantic import BaseModel, FilePath, Strict


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
    for key, (prefixes, tables) in _declared(keys).items():
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
def _declared(keys: type[BaseModel]) -> Mapping[str, tuple[Prefixes, Tables]]:
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
