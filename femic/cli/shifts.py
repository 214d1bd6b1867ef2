"""The command `shifts`: a wheelset on its track at many lateral shifts."""

from pathlib import Path
from typing import Annotated, Literal

from cyclopts import Parameter

from femic.cache import folders
from femic.cli.progress import terminal
from femic.cli.work import DEFAULT_WORK, OUT, Work, announce
from femic.lazy import lazy_imports
from femic.scenes.load import name_of
from geometries.errors import WrongInput

with lazy_imports():
    from compare.pages import shifts as page
    from femic.results import wheelset as compute
    from femic.results import wheelset_scene as scenes
    from femic.shifts import specification as specifications


def shifts(
    specification: Annotated[
        str | None,
        Parameter(
            help="TOML file, or a built-in specification: s1002-on-60e1, s1002-on-60e1-worn; `--show` "
            "prints it"
        ),
    ] = None,
    /,
    *,
    show: Annotated[
        bool,
        Parameter(negative="", help="print a built-in specification with every key, default: s1002-on-60e1"),
    ] = False,
    write: Annotated[
        float | None,
        Parameter(
            help="lateral shift [mm]: write the scene of one wheel at this shift, for `femic contact`, "
            "`stresses` and `export`, and solve nothing"
        ),
    ] = None,
    wheel: Annotated[
        Literal["left", "right"] | None,
        Parameter(help="wheel for --write; default: the wheel that moves towards its rail"),
    ] = None,
    work: Work = DEFAULT_WORK,
) -> None:
    """Solve the contacts of a wheelset at many lateral shifts; write shifts.nc and a report.

    Both wheels stand on their rails. Each contact is solved with several ICs, and all patches of a wheel
    together.
    """
    if wheel is not None and write is None:
        raise WrongInput(f"--wheel {wheel}: only with --write SHIFT; give both or neither")
    console = terminal()
    if show:
        known = specifications.builtin_names()
        if specification is not None and specification not in known:
            raise WrongInput(f"SPECIFICATION {specification!r} with --show: one of {', '.join(known)}")
        text = specifications.example(*([specification] if specification else []))
        console.print(text, soft_wrap=True, end="")
        return
    if specification is None:
        raise WrongInput("SPECIFICATION: name a TOML file; `femic shifts --show` prints an example")
    name, text, file = specifications.load_shifts(specification)
    folder: Path = work.out or OUT / name_of(Path(specification))
    if write is not None:
        with folders.locked(folder):
            path = scenes.write_scene(file, write, folder, name, wheel)
        console.print(f"Scene: {path}", soft_wrap=True)
        return
    with work.options(folder, console) as options:
        dataset = compute.compute_shifts(file, text, options)
        options.watch.on_stage("charts of the report")
        report = page.write_shifts(dataset, folder)
    console.print(page.summary(dataset), soft_wrap=True)
    announce(report, console)
