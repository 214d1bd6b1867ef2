"""Studies of random scenes, one file each: solved once, in parallel processes, and read again."""

import json
import logging
from collections.abc import Callable, Iterator, Sequence
from functools import partial
from pathlib import Path
from typing import Any

from femic.advice.scenes import random_scene
from femic.advice.study import studied
from femic.cache.digests import results_digest
from femic.cache.files import write_text
from femic.cache.processes import in_processes
from geometries.errors import Failure, WrongInput

Entry = dict[str, Any]  # of `study.Study`; of a scene without a contact: its seed, number and why

MODULE = "femic.advice.study"  # which makes scenes and solves them, with all that it imports

log = logging.getLogger(__name__)


def code_of_studies() -> str:
    """Return the digest of the code that makes scenes and solves them."""
    return results_digest(MODULE)


def solved(seed: int, number: int) -> Entry:
    """Return the entry of a scene."""
    try:
        return studied(random_scene(seed, number), seed, number).entry
    except (Failure, WrongInput) as failure:
        return {"seed": seed, "number": number, "failure": str(failure)}


def entries(folder: Path, seed: int, code: str | None = None) -> list[Entry]:
    """Return the stored entries of a seed by number; with `code` only those that it made."""
    found = [entry for path in folder.glob(f"{seed}-*.json") if (entry := _read(path)) is not None]
    chosen = [entry for entry in found if code in (None, entry["code"])]
    return sorted(chosen, key=lambda entry: int(entry["number"]))


def solve_missing(
    folder: Path,
    wanted: Sequence[tuple[int, int]],
    workers: int,
    solve: Callable[[int, int], Entry] = solved,
) -> Iterator[Entry]:
    """Solve the scenes, pairs of seed and number, that this code has not stored; yield each when it is.

    Each is stored at once: after an interruption the others are solved.
    """
    folder.mkdir(parents=True, exist_ok=True)
    code = code_of_studies()
    missing = [pair for pair in wanted if (_read(_path(folder, *pair)) or {}).get("code") != code]
    yield from in_processes(partial(_solve_and_store, folder, code, solve), missing, workers)


def _solve_and_store(
    folder: Path, code: str, solve: Callable[[int, int], Entry], pair: tuple[int, int]
) -> Entry:
    entry = solve(*pair) | {"code": code}
    write_text(json.dumps(entry) + "\n", _path(folder, *pair))
    return entry


def _path(folder: Path, seed: int, number: int) -> Path:
    return folder / f"{seed}-{number}.json"


def _read(path: Path) -> Entry | None:
    """Return an entry; None where there is none, or a damaged one."""
    try:
        return dict(json.loads(path.read_text(encoding="utf-8")))
    except FileNotFoundError:
        return None
    except ValueError:
        log.warning(f"{path}: damaged; it is solved again")
        return None
