"""The command `profiles`: the standard ones, and how files were understood."""

import os
import re
from difflib import get_close_matches
from pathlib import Path
from typing import Annotated, Literal

from cyclopts import Parameter
from rich.table import Table

from femic.cache import folders
from femic.cli.progress import terminal
from femic.cli.work import OUT, TABLE_WIDTH, announce, whole_number
from femic.lazy import lazy_imports
from femic.scenes.load import name_of
from femic.scenes.profiles import Reading, prepared_file
from geometries.errors import WrongInput
from geometries.profiles.files import ENDINGS, write_profile
from geometries.profiles.profile import UNITS, Kind
from geometries.profiles.sections import SectionChoice
from geometries.profiles.standards import NAMED

with lazy_imports():
    import xarray as xr

    from compare.pages import profiles as page
    from femic.results import profiles as results

# in messages of the readers
ARGUMENTS = re.compile(r"\b(give )?(kind|axes|unit|surface|section|section_at|tolerance) = ")


def profiles(
    *names: Annotated[
        str, Parameter(help="files, or names of built-in profiles; without names: list the built-in profiles")
    ],
    kind: Annotated[Kind | None, Parameter(help="rail or wheel, if the file does not state it")] = None,
    axes: Annotated[
        str | None,
        Parameter(
            help="directions of y and z in the file: field or centre (of the track), up or down, or one "
            "of each, such as 'centre down'; needed if the file does not show them (MiniProf mostly: "
            "centre)"
        ),
    ] = None,
    unit: Annotated[
        str | None, Parameter(help=f"{', '.join(UNITS)}; where the file does not show it")
    ] = None,
    surface: Annotated[
        int | None,
        Parameter(help="number of the running surface, if the file has several", converter=whole_number),
    ] = None,
    section: Annotated[
        int | None,
        Parameter(
            help="number of the section, for a list of sections (.slcs, .slcw)", converter=whole_number
        ),
    ] = None,
    section_at: Annotated[
        float | None, Parameter(help="position of the section instead of its number, in the unit of the list")
    ] = None,
    tolerance: Annotated[
        float | Literal["cross-validation"],
        Parameter(
            help="smoothing: rms distance of the points from the curve [mm], or cross-validation to find "
            "it; 0: a curve through all points"
        ),
    ] = 0.0,
    write: Annotated[
        Path | None,
        Parameter(
            help="write the profile, smoothed if it has a tolerance, as a spline block: .prr (rail), .prw "
            "(wheel)"
        ),
    ] = None,
    out: Annotated[Path | None, Parameter(help="folder for the results; default out/profiles")] = None,
) -> None:
    """List the built-in profiles, or show how femic reads profile files: axes, smoothing, curvature."""
    console = terminal(width=TABLE_WIDTH)
    if not names:
        table = Table("name", "kind", "title", "source", box=None, pad_edge=False)
        for name, entry in NAMED.items():
            table.add_row(name, entry.kind, entry.title, entry.source)
        console.print(table)
        return
    reading = Reading(kind, axes, unit, surface, tolerance, SectionChoice(section, section_at))
    read = [_read(name, reading) for name in names]
    ones = [one for one, _ in read]
    files, own_kind = [one.attrs["file"] for one in ones], ones[0].attrs["kind"]
    if twice := next((file for k, file in enumerate(files) if file in files[:k]), None):
        raise WrongInput(f"{twice}: given twice; remove one")
    if write is not None:
        if len(ones) > 1:
            raise WrongInput(f"--write {write}: {len(ones)} profiles given; give one")
        if ENDINGS.get(write.suffix.lower()) != own_kind:
            ending = next(ending for ending, kind in ENDINGS.items() if kind == own_kind)
            raise WrongInput(f"--write {write}: the name of a {own_kind}'s file must end in {ending}")
        if write.is_dir() or not os.access(write.parent, os.W_OK):
            raise WrongInput(f"--write {write}: cannot be written: name a file in a folder that exists")
    targets = page.page_folders(ones, out or OUT / "profiles")
    for one, target in zip(ones, targets, strict=True):
        with folders.locked(target):
            report = page.write_profile_page(one, target)
        console.print(" ".join(filter(None, [page.summary(one), one.attrs["doubt"]])), soft_wrap=True)
        announce(report, console)
    if write is not None:
        write_profile(read[0][1](), write)
        console.print(f"Written: {write}", soft_wrap=True)


def _read(name: str, reading: Reading) -> "tuple[xr.Dataset, results.MakePoints]":
    """Return a profile of a file, or one of the package of a name; raise WrongInput."""
    path = Path(name)
    if path.exists():
        name_of(path)
        try:
            prepared = prepared_file(path, reading)  # raises before anything heavy is loaded
        except WrongInput as error:
            # arguments of the readers as options of the command
            text = ARGUMENTS.sub(lambda found: f"{found[1] or ''}--{found[2].replace('_', '-')} ", str(error))
            raise WrongInput(text) from error
        return results.file_profile(prepared, path)
    if name not in NAMED:
        similar = [known for known in NAMED if get_close_matches(name.lower(), [known.lower()], 1, 0.5)]
        hint = f"; did you mean {' or '.join(similar)}?" if similar else "."
        raise WrongInput(
            f"profile {name!r}: no such file and no built-in profile{hint} The package has {', '.join(NAMED)}"
        )
    if reading != Reading():
        raise WrongInput(f"{name}: a built-in profile; leave out the options for files")
    return results.package_profile(name)
