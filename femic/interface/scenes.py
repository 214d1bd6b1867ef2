"""Scenes of pairs that Python describes, and of files."""

from pathlib import Path

from compare.ics import run
from femic.interface.arguments import with_checked_arguments
from femic.interface.options import DEFAULT, Options
from femic.interface.threads import in_turn
from femic.scenes.scene import Scene


@with_checked_arguments
@in_turn
def run_scene(scene: Scene, out: str | Path, options: Options = DEFAULT) -> Path:
    """Compute the ICs of a scene as `femic run` does, and write them with a report; return its path.

    `scene` comes from `load_scene`, with its own accuracy and engine: of `options` only workers, store and
    report count. Raises WrongInput, and Failure where the tolerance cannot be met.
    """
    return run.run_scene(scene, Path(out), options.run)
