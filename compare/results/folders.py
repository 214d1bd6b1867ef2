"""Folders of results."""

from pathlib import Path

from geometries.errors import WrongInput


def checked(folder: Path) -> Path:
    """The folder; raises WrongInput where it is a file."""
    if folder.exists() and not folder.is_dir():
        raise WrongInput(f"--out {folder}: is a file; name a folder")
    return folder


def made(folder: Path) -> Path:
    """The folder, made if it is not there."""
    checked(folder).mkdir(parents=True, exist_ok=True)
    return folder
