"""`femic doctor` checks whether an installation is complete, femic's own, and right.

It checks packages, libraries, names, and a few results with known values.
"""

import base64
import hashlib
import platform
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from importlib import metadata
from importlib.util import find_spec
from pathlib import Path
from time import perf_counter

import numpy as np
from packaging.requirements import Requirement
from rich.table import Table
from rich.text import Text

from femic.cli.main import OWN_NAMES
from femic.cli.progress import terminal
from femic.lazy import lazy_imports
from geometries.errors import Failure

with lazy_imports():
    from compare.report import views

# --- the command ----------------------------------------------------------------------------------------


OK, NO, LACKING = Text("ok", "green"), Text("no", "red"), Text("–", "yellow")


def doctor() -> None:
    """Check libraries, versions, import names and two known results; takes half a minute."""
    console = terminal()
    wrong = []
    table = Table(box=None, pad_edge=False, show_header=False)
    with console.status("checking"):
        for finding in findings():
            mark = OK if finding.holds else NO if finding.matters else LACKING
            remedy = "" if finding.holds else f"\n→ {finding.remedy}"
            table.add_row(mark, finding.name, f"{finding.text}{remedy}")
            if not finding.holds and finding.matters:
                wrong.append(finding.name)
    console.print(table)
    if wrong:
        raise Failure(f"this installation has problems: {', '.join(wrong)}")
    console.print("This installation is in order.")


# --- findings -------------------------------------------------------------------------------------------


DEVELOPERS = ("dev", "site")  # extras for work on femic itself
HERTZ_TOLERANCE = 0.01  # of the largest pressure on some 20 elements across the patch
C_TOLERANCE = 0.01  # that of the C which is computed


@dataclass(frozen=True)
class Finding:
    """A thing that was checked: whether it is as it must be, what it is, and what to do about it if not.

    `matters` is False where femic works without it, with less.
    """

    name: str
    holds: bool
    text: str
    remedy: str = ""
    matters: bool = True


def findings() -> Iterator[Finding]:
    """Yield all findings, the quick ones first; the self-test takes longest."""
    required, version = metadata.metadata("femic")["Requires-Python"], platform.python_version()
    holds = Requirement(f"python{required}").specifier.contains(version)
    yield Finding("Python", holds, version, f"install Python {required}")
    yield from dependencies()
    for name in OWN_NAMES:
        yield import_name(name)
    yield unchanged_files()
    try:
        import gmsh  # noqa: PLC0415
    except OSError as error:  # libraries of the system are missing
        yield Finding("Gmsh", False, str(error), "install the system library that the message names")
    else:
        yield Finding("Gmsh", True, f"loads ({gmsh.__version__})")
    drawn = views.can_render()
    text = (
        "draws without a screen" if drawn else ("cannot draw without a screen: no 3D pictures for printing")
    )
    yield Finding("3D pictures", drawn, text, "apt-get install libegl1", matters=False)
    for test in SELF_TESTS:
        yield self_test(*test)


def dependencies() -> Iterator[Finding]:
    """Yield a finding for each library that femic requires, also for the optional ones that are missing."""
    extras = metadata.metadata("femic").get_all("Provides-Extra") or []
    for line in metadata.requires("femic") or []:
        requirement, extra = Requirement(line), ""  # of an extra, unless femic always needs it
        name, marker = requirement.name, requirement.marker
        if marker is not None and not marker.evaluate({"extra": ""}):
            extra = next(extra for extra in extras if marker.evaluate({"extra": extra}))
        if name == "femic" or extra in DEVELOPERS:
            continue
        optional, required = f", for the extra {extra!r}" if extra else "", f"{name}{requirement.specifier}"
        try:
            version = metadata.version(name)
        except metadata.PackageNotFoundError:
            remedy = f"pip install '{f'femic[{extra}]' if extra else required}'"
            yield Finding(name, False, f"not installed{optional}", remedy, matters=not extra)
        else:
            holds = requirement.specifier.contains(version)
            yield Finding(name, holds, f"{version}{optional}", f"pip install '{required}'")


def import_name(name: str) -> Finding:
    """Check that one of our import names leads to femic's own files, and belongs to femic alone."""
    spec, own = find_spec(name), Path(__file__).parents[2]
    if spec is None or spec.origin is None:
        return Finding(f"import {name}", False, "cannot be found", "reinstall femic")
    place, owners = Path(spec.origin).parent, set(metadata.packages_distributions().get(name, ()))
    others = sorted(owners - {"femic"})
    elsewhere = place.parent.resolve() != own.resolve()
    text = str(place) + (f", also of the package {', '.join(others)}" if others else "")
    cause = ", ".join(others) or "something else"
    remedy = f"{cause} installs the same name: install femic in a separate virtual environment"
    return Finding(f"import {name}", not elsewhere and not others, text, remedy)


def unchanged_files() -> Finding:
    """Compare the installed files with the hashes that were installed with them."""
    files = [file for file in metadata.files("femic") or () if file.hash and file.suffix == ".py"]
    changed = []
    for file in files:
        path, installed = Path(str(file.locate())), file.hash
        content = path.read_bytes() if path.is_file() else None
        assert installed is not None
        digest = b"" if content is None else hashlib.new(installed.mode, content).digest()
        if base64.urlsafe_b64encode(digest).rstrip(b"=").decode() != installed.value:
            changed.append(str(file))
    text = f"{len(files)} files as installed" if not changed else f"changed or missing: {', '.join(changed)}"
    if not any(str(file).startswith("femic/") for file in files):
        text = "installed from a source folder (editable)"
    return Finding("files", not changed, text, "another package or an editor changed them: reinstall femic")


def self_test(name: str, unit: str, compute: Callable[[], tuple[float, float]], tolerance: float) -> Finding:
    """Compute a number, and what it must be within a tolerance, a share; any error is a finding, too."""
    start, remedy = perf_counter(), "reinstall femic, or report this"
    try:
        value, exact = compute()
    except Exception as error:  # whatever goes wrong on a foreign machine is to be told, not raised
        return Finding(name, False, f"{type(error).__name__}: {error}", remedy)
    text = f"{value:.5g} {unit}, exactly {exact:.5g} ({perf_counter() - start:.1f} s)"
    return Finding(name, abs(value / exact - 1) < tolerance, text, remedy)


def _half_space() -> tuple[float, float]:
    """Return C_nn of a flat body on a square patch less that 2 mm beside it [mm/N], and closed formulas.

    The discount cancels in the difference. Love's formula gives the first, Boussinesq's the second.
    """
    import femic  # noqa: PLC0415

    steel, half, beside = femic.Material(E=210e3, nu=0.28), 0.2, 2.0
    flat = femic.Body(femic.plane(), steel)
    ics = femic.compute_ics(
        femic.Pair(flat, flat),
        femic.Patch(a=half, b=half),
        [femic.points([0.0, beside], [0.0, 0.0])],
        ["C"],
        bodies=["lower"],
        components=["nn"],
        options=femic.Options(tolerance=0.01),
    )
    on_patch, away = ics.ic.sel(variant="C", body="lower", i="n", j="n").values
    exact = (1 - steel.nu**2) / (np.pi * steel.E) * (2 * np.log(1 + np.sqrt(2)) / half - 1 / beside)
    return float(on_patch - away), exact


def _hertz() -> tuple[float, float]:
    """Return the largest pressure [MPa] of a ball-like wheel on a rail's arc with A, and Hertz's formula."""
    import femic  # noqa: PLC0415
    from femic.contact.exact.hertz import PointContact, combined_modulus  # noqa: PLC0415

    steel = femic.Material(E=210e3, nu=0.28)
    rail = femic.Body(femic.arc(80.0, 60.0), steel)
    wheel = femic.Body(femic.plane(), steel, rolling_radius=460.0)
    pressed = femic.solve_contact(femic.Pair(wheel, rail), femic.Frictionless(loads=[5e3]), ["A"])
    surfaces = PointContact(1 / 460.0, 1 / 80.0, combined_modulus(steel, steel))
    return float(pressed.p_max.squeeze()), surfaces.at_load(5e3).p_max


SELF_TESTS = (
    ("C of a half-space against Love and Boussinesq", "mm/N", _half_space, C_TOLERANCE),
    ("contact with A against Hertz", "MPa", _hertz, HERTZ_TOLERANCE),
)
