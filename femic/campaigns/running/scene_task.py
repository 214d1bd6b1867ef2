"""Scenes as tasks: their tables, the keys of their results, and their stored results.

Scenes are identified by their tables and by the contents of the files that they name: campaigns that share a
store share scenes, too.
"""

import json
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, replace
from functools import cache
from hashlib import sha256
from pathlib import Path
from typing import Any

import xarray as xr

from femic.cache.digests import results_digest
from femic.cache.store import Store
from femic.campaigns.dataset import outcomes
from femic.campaigns.dataset.outcomes import SceneOutcome
from femic.campaigns.files.campaign import Campaign
from femic.campaigns.results import registry
from femic.scenes.ic_names import MAP, is_map
from femic.scenes.load import scene_from_table
from femic.scenes.scene import Scene

NAME = "scene"  # of every scene in messages: scenes that campaigns share have no other


@dataclass(frozen=True)
class SceneTask:
    """A scene: its table, and the keys of its results in the store by kind."""

    table: Mapping[str, Any]
    keys: Mapping[str, str]
    retry: bool = False  # whether to compute again what failed before

    @property
    def digest(self) -> int:
        """A number of 64 bits, not 0, that depends on all inputs of the scene's results."""
        return int.from_bytes(sha256("".join(self.keys.values()).encode()).digest()[:8]) or 1

    @property
    def scene(self) -> Scene:
        """The scene, without the check with the other engine; raises BadScene."""
        return replace(scene_from_table(dict(self.table), NAME), check=None)


def scene_task(table: Mapping[str, Any], keep: tuple[str, ...], store: Store) -> SceneTask:
    """Return the task of a scene; keys depend on its table, its files, and the code."""
    plain = json.loads(json.dumps(table, default=str), parse_int=float)  # 1 and 1.0 are the same
    facts = results_digest(registry.__name__), json.dumps(plain, sort_keys=True), *_contents(table)
    return SceneTask(table, {name: store.key(f"sweep-{name}", name, *facts) for name in keep})


def task_of(campaign: Campaign, number: int, store: Store) -> SceneTask:
    """Return the task of the scene at a point of a campaign."""
    return scene_task(campaign.scene_table(campaign.point(number)), campaign.keep, store)


def tasks_of(campaign: Campaign, store: Store) -> Iterator[tuple[int, SceneTask]]:
    """Yield the numbers and tasks of all scenes of a campaign, in its order."""
    for number in campaign.order:
        yield number, task_of(campaign, number, store)


def stored_parts(task: SceneTask, store: Store) -> dict[str, SceneOutcome]:
    """Return what the store has of a scene, by kind of results."""
    parts = {kind: outcomes.get(store, key) for kind, key in task.keys.items()}
    return {kind: part for kind, part in parts.items() if part is not None}


def stored_outcome(task: SceneTask, store: Store) -> SceneOutcome | None:
    """Return the outcome of a scene, None where the store lacks a part of it."""
    parts = stored_parts(task, store)
    return merged_outcome(parts) if len(parts) == len(task.keys) else None


def merged_outcome(parts: Mapping[str, SceneOutcome]) -> SceneOutcome:
    """Return all parts of a scene as one; where some failed, it has the others, and says why."""
    failures: dict[str, list[str]] = {}
    for kind, part in parts.items():
        if part.failure:
            failures.setdefault(part.failure, []).append(kind)
    everything = len(parts) == len(next(iter(failures.values()), ()))
    messages = [
        message if everything else f"{', '.join(names)}: {message}" for message, names in failures.items()
    ]
    datasets = {kind: part.dataset for kind, part in parts.items() if not part.failure}
    try:
        merged = registry.merged(datasets)
    except ValueError as error:
        merged, messages = xr.Dataset(), [*messages, f"results of several kinds do not fit together: {error}"]
    return SceneOutcome(merged, "; ".join(messages), sum(part.seconds for part in parts.values()))


def _contents(table: Mapping[str, Any]) -> Iterator[str]:
    """Yield digests of the files that a scene names: contours, gaps, maps of C."""
    contact = _table(table, "contact")
    contours = [_table(_table(table, body), "contour") for body in ("lower", "upper")]
    ics = contact.get("ics")
    maps = [name.removeprefix(MAP) for name in ics if is_map(str(name))] if isinstance(ics, list) else []
    for name in (*(contour.get("file") for contour in contours), contact.get("extra_gap"), *maps):
        if isinstance(name, str) and (path := Path(name)).exists():
            files = sorted(file for file in path.rglob("*") if file.is_file()) if path.is_dir() else [path]
            yield _digest(tuple((file, file.stat().st_mtime_ns) for file in files))


def _table(table: Mapping[str, Any], name: str) -> Mapping[str, Any]:
    """Return a table in a table, empty where there is none; other entries are refused elsewhere."""
    inner = table.get(name)
    return inner if isinstance(inner, Mapping) else {}


@cache
def _digest(files: tuple[tuple[Path, int], ...]) -> str:
    """Return the digest of files with their times of modification."""
    digest = sha256()
    for file, _ in files:
        digest.update(file.read_bytes())
    return digest.hexdigest()
