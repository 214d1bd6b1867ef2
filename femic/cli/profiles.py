"""The command `profiles`: the standard ones, and how files were understood."""

import os
import re
from collections.abc import Sequence
from dataclasses import dataclass
from difflib import get_close_matches
from pathlib import Path
from typing import Annotated, Literal

from cyclopts import Parameter
from rich.table import Table

from femic.cache import files as folders
from femic.cli.progress import terminal
from femic.cli.work import OUT, TABLE_WIDTH, announce, whole_number
from femic.late import lazy_imports
from femic.scenes.load import name_of
from femic.scenes.profiles import Reading, prepared_file
from geometries.errors import WrongInput
from geometries.profiles.files import ENDINGS, write_profile
from geometries.profiles.profile import UNITS, Kind
from geometries.profiles.sections import SectionChoice
from geometries.profiles.standards import NAMED

with lazy_imports():
    from compare.pages import profiles as page
    from femic.results import profiles as understood

ARGUMENTS = re.compile(
    r"\b(give )?(kind|axes|unit|surface|section|section_at|tolerance) = "
)  # in messages of the readers


@Parameter(name="*")
@dataclass(frozen=True)
class FileOptions:
    """What a file does not say, and its smoothing."""

    kind: Annotated[Kind | None, Parameter(help="where the file does not say it")] = None
    axes: Annotated[
        str | None,
        Parameter(
            help="where y grows and z points in the file: field or centre (of the track), up or down, or one "
            "of each, as 'centre down'; asked for where the file does not show it (MiniProf mostly: centre)"
        ),
    ] = None
    unit: Annotated[str | None, Parameter(help=f"{', '.join(UNITS)}; where the file does not show it")] = None
    surface: Annotated[
        int | None,
        Parameter(help="number of the running surface, where a file has several", converter=whole_number),
    ] = None
    section: Annotated[
        int | None,
        Parameter(
            help="of a list of sections (.slcs, .slcw): the number of the section", converter=whole_number
        ),
    ] = None
    section_at: Annotated[
        float | None, Parameter(help="instead of --section: its position, in the unit of the list")
    ] = None
    tolerance: Annotated[
        float | Literal["cross-validation"],
        Parameter(
            help="smoothing: rms distance of the points from the curve [mm], or cross-validation, which "
            "finds it; 0: through all points"
        ),
    ] = 0.0

    @property
    def reading(self) -> Reading:
        """How files are read."""
        choice = SectionChoice(self.section, self.section_at)
        return Reading(self.kind, self.axes, self.unit, self.surface, self.tolerance, choice)


NO_OPTIONS = FileOptions()


def profiles(
    *names: Annotated[str, Parameter(help="files, or names of profiles of the package; none: list these")],
    options: FileOptions = NO_OPTIONS,
    write: Annotated[
        Path | None,
        Parameter(
            help="write the profile, smoothed if it has a tolerance, as a spline block: .prr (rail), .prw "
            "(wheel)"
        ),
    ] = None,
    out: Annotated[Path | None, Parameter(help="folder for the results; default out/profiles")] = None,
) -> None:
    """List the profiles of the package, or show how files were understood: axes, smoothing, curvature."""
    console = terminal(width=TABLE_WIDTH)
    if not names:
        console.print(_standards())
        return
    ones = [_understood(name, options) for name in names]
    _check([one.file for one in ones], [one.kind for one in ones], write)
    targets = page.page_folders(ones, out or OUT / "profiles")
    for one, target in zip(ones, targets, strict=True):
        with folders.locked(target):
            report = page.write_profile_page(one, target)
        console.print(" ".join([page.summary(one), *page.doubts(one)]), soft_wrap=True)
        announce(report, console)
    if write is not None:
        write_profile(ones[0].as_points(), write)
        console.print(f"Written: {write}", soft_wrap=True)


def _standards() -> Table:
    """Return the profiles of the package as a table."""
    table = Table("name", "kind", "title", "source", box=None, pad_edge=False)
    for name, entry in NAMED.items():
        table.add_row(name, entry.kind, entry.title, entry.source)
    return table


def _understood(name: str, options: FileOptions) -> "understood.Understood":
    """Return a profile of a file, or one of the package of a name; raise WrongInput."""
    path = Path(name)
    if path.exists():
        name_of(path)
        try:
            prepared = prepared_file(path, options.reading)  # raises before anything heavy is loaded
        except WrongInput as error:
            raise WrongInput(ARGUMENTS.sub(_option, str(error))) from error
        return understood.of_file(prepared, path)
    if name not in NAMED:
        similar = [known for known in NAMED if get_close_matches(name.lower(), [known.lower()], 1, 0.5)]
        hint = f"; did you mean {' or '.join(similar)}?" if similar else "."
        raise WrongInput(
            f"profile {name!r}: no such file, and none of the package{hint} The package has "
            f"{', '.join(NAMED)}"
        )
    if options != NO_OPTIONS:
        raise WrongInput(f"{name}: a profile of the package: leave out the options of files")
    return understood.of_package(name)


def _option(argument: re.Match[str]) -> str:
    """Return an argument of the readers in a message as the option of the command."""
    return f"{argument[1] or ''}--{argument[2].replace('_', '-')} "


def _check(files: Sequence[str], kinds: Sequence[Kind], write: Path | None) -> None:
    """Raise WrongInput for a profile that is given twice, and for a file to write with another ending."""
    twice = next((file for k, file in enumerate(files) if file in files[:k]), None)
    if twice is not None:
        raise WrongInput(f"{twice}: given twice; leave one out")
    if write is None:
        return
    if len(files) > 1:
        raise WrongInput(f"--write {write}: {len(files)} profiles; give one")
    if ENDINGS.get(write.suffix.lower()) != kinds[0]:
        ending = next(ending for ending, kind in ENDINGS.items() if kind == kinds[0])
        raise WrongInput(f"--write {write}: the name of a {kinds[0]}'s file must end in {ending}")
    if write.is_dir() or not os.access(write.parent, os.W_OK):
        raise WrongInput(f"--write {write}: cannot be written: name a file in a folder that exists")
