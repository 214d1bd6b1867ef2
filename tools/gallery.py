"""How the gallery of the site runs the scripts in examples/, and finds what they have drawn."""

import shutil
from pathlib import Path
from typing import Any

from sphinx_gallery.scrapers import figure_rst

OUT = Path(__file__).parents[1] / "out" / "gallery"  # pictures, and the store of solved models


def arguments(_gallery: dict[str, Any], _script: dict[str, Any]) -> list[str]:
    """Return the arguments with which a script is run."""
    OUT.mkdir(parents=True, exist_ok=True)
    return ["--out", str(OUT)]


def picture(_block: tuple[Any, ...], script: dict[str, Any], gallery: dict[str, Any]) -> str:
    """Return the picture that a script has written to its folder, as the page shows it."""
    written = OUT / f"{Path(script['src_file']).stem}.png"
    if not written.exists():
        return ""
    shown = script["image_path_iterator"].next()
    shutil.copy(written, shown)
    return figure_rst([shown], gallery["src_dir"])
