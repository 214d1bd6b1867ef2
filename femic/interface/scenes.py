"""Scenes of pairs that Python describes, and of files."""

from collections.abc import Mapping
from pathlib import Path
from typing import Any

from compare.ics import run
from femic.interface.arguments import with_checked_arguments
from femic.interface.bodies import Pair, plain
from femic.interface.options import DEFAULT, Options
from femic.interface.threads import in_turn
from femic.scenes.load import scene_from_table
from femic.scenes.scene import Scene

NAME = "pair"  # of scenes that Python describes, in messages


def scene_of(pair: Pair, options: Options, tables: Mapping[str, Any]) -> Scene:
    """Return the scene of a pair with further tables; raise WrongInput for what does not fit together."""
    return scene_from_table(plain(pair.tables | {"engine": options.table} | dict(tables)), NAME)


@with_checked_arguments
@in_turn
def run_scene(scene: Scene, out: str | Path, options: Options = DEFAULT) -> Path:
    """Compute the ICs of a scene as `femic run` does, and write them with a report; return its path.

    `scene` comes from `load_scene`, with its own accuracy and engine: of `options` only workers, store and
    report count. Raises WrongInput, and Failure where the tolerance cannot be met.
    """
    return run.run_scene(scene, Path(out), options.run)
