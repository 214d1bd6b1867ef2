"""Names of scenes and campaigns: the names of their files, which name the folders of results, too."""

from pathlib import Path

from femic.scenes.errors import BadScene


def name_of(path: Path) -> str:
    """Return the name of a scene or campaign file; raise BadScene for one that no folder can have."""
    name = path.stem
    if not name.strip(" .") or not name.isprintable():
        raise BadScene(
            f"{str(path)!r}: its name without .toml names the folder of results, and no "
            f"folder can be called {name!r}: rename it"
        )
    return name
