"""Names of scenes and campaigns: those of their files, which name the folders of results."""

from pathlib import Path

from femic.scenes.errors import BadScene


def name_of(path: Path) -> str:
    """The name of what a file describes; raises BadScene for one that is no name of a folder of its own."""
    name = path.stem
    if not name.strip(" .") or not name.isprintable():
        raise BadScene(
            f"{str(path)!r}: its name without .toml names the folder of results, and {name!r} is no name of "
            "one: rename it"
        )
    return name
