"""The folders that results are written to."""

from pathlib import Path

from geometries.errors import WrongInput


def checked(folder: Path) -> Path:
    """Return the folder; raises WrongInput if the path is a file."""
    if folder.exists() and not folder.is_dir():
        raise WrongInput(f"--out {folder}: is a file; name a folder")
    return folder


def made(folder: Path) -> Path:
    """Return the folder, which is created where it does not exist; raises WrongInput if it is a file."""
    checked(folder).mkdir(parents=True, exist_ok=True)
    return folder
