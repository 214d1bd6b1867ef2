"""Draw pictures of the docs with femic itself: python tools/draw_concepts.py [name ...].

Each shows one idea; numbers in them are computed. `tall` and `corner` take minutes, the others a minute
in all. Solved models are kept in out/pictures/. Only pictures that changed need to be committed.
"""

import sys
from collections.abc import Callable
from pathlib import Path

import matplotlib as mpl
import numpy as np
import xarray as xr
from matplotlib.axes import Axes
from matplotlib.collections import PolyCollection
from matplotlib.figure import Figure
from matplotlib.patches import Arc

import femic
from approx.halfspace import HalfSpace
from femic.reference.harmonic.section import SectionSize, section_mesh
from femic.reference.meshing import Cells
from geometries.bodies import Body, Domain
from geometries.contours import Contour, arc
from geometries.materials import Material, one_body
from geometries.patches import Patch
from geometries.surfaces import LOWER

ROOT = Path(__file__).parents[1]
IMAGES = ROOT / "docs" / "images"
STORE = str(ROOT / "out" / "pictures")
STEEL = Material(210e3, 0.28)
RAIL, WHEEL = "#b9c4d0", "#d9c7ae"
BLUE, RED, GREEN, ORANGE = "#0072b2", "#d55e00", "#009e73", "#e69f00"
ARROW = {"arrowstyle": "-|>", "linewidth": 1.8, "shrinkA": 0, "shrinkB": 0}
STYLE = {"font.size": 10, "figure.dpi": 110, "axes.spines.top": False, "axes.spines.right": False}
LOOKS = {  # label, colour, dashes of the curves of ICs
    "C": ("C, reference", "black", "-"),
    "Bhat": ("B̂", RED, "--"),
    "B": ("B", ORANGE, "-."),
    "A": ("A, half-space", BLUE, ":"),
}
STEEP = np.pi / 3


def main() -> None:
    names = sys.argv[1:] or list(PICTURES)
    with mpl.rc_context(STYLE):
        for name in names:
            PICTURES[name]().savefig(IMAGES / f"concept_{name}.png", dpi=130)


def arrow(axes: Axes, start: np.ndarray, along: np.ndarray, colour: str, text: str = "") -> None:
    """Draw an arrow from a point, and a text at its end."""
    end = np.asarray(start) + along
    axes.annotate("", end, start, arrowprops=ARROW | {"color": colour})
    if text:
        axes.annotate(
            text,
            end,
            xytext=6 * np.asarray(along) / np.linalg.norm(along),
            color=colour,
            textcoords="offset points",
            ha="center",
            va="center",
        )


def ic() -> Figure:
    """Draw the displacement of a flat surface under a load on one element, 250 times as large."""
    s = np.linspace(-4, 4.2, 821)
    on_plane = HalfSpace(one_body(STEEL, LOWER)).ics(Patch(0.5, 0.5), 0.0, s)
    u_n, u_s = on_plane[2, 2], on_plane[1, 2]
    pressure, scale = 1000.0, 250.0  # MPa, drawn displacement over the real one
    figure = Figure((7.2, 3.0), layout="constrained")
    axes = figure.subplots()
    moved = s + scale * pressure * -u_s, -scale * pressure * u_n
    axes.fill_between(*moved, -3.2, color=RAIL)
    axes.plot(s, 0 * s, color="grey", linestyle=":", linewidth=1)
    axes.plot(*moved, color="black", linewidth=1.4)
    loaded, read = np.abs(s) <= 0.5, np.abs(s - 2) <= 0.5
    for part, colour, text in ((loaded, RED, "J"), (read, BLUE, "I")):
        axes.plot(moved[0][part], moved[1][part], color=colour, linewidth=4)
        axes.annotate(
            text,
            (np.mean(moved[0][part]), moved[1][part].min()),
            xytext=(0, -16),
            textcoords="offset points",
            ha="center",
            color=colour,
            fontweight="bold",
        )
    for at in np.linspace(-0.4, 0.4, 5):
        arrow(axes, np.array([at, 1.4]), np.array([0, -1.15]), RED)
    axes.annotate("1000 MPa on J", (0.7, 1.0), color=RED)
    axes.annotate("IC$_{nn}$ × 1000 MPa", (2.8, -0.55), color=BLUE)
    middle = int(np.argmin(np.abs(s - 2)))
    arrow(axes, np.array([2.65, 0.0]), np.array([0.0, moved[1][middle]]), BLUE)
    axes.set(xlabel="s [mm]", ylim=(-2.6, 1.5), xlim=(-4, 4.2), yticks=[])
    axes.spines["left"].set_visible(False)
    return figure


def frames() -> Figure:
    """Draw rail and wheel, their contours and local directions."""
    figure = Figure((7.2, 3.41))
    axes = figure.add_axes((0, 0, 1, 1))
    lower, upper = arc(10.0, STEEP, STEEP), arc(11.5, STEEP, STEEP)
    s = np.linspace(-15, 15, 301)
    (y, z), (yw, zw) = lower.position(s), upper.position(s)
    axes.fill_between(y, z, -11, color=RAIL)
    axes.fill_between(yw, zw + 0.6, 6.0, color=WHEEL)
    axes.plot(y, z, color="black", linewidth=1.2)
    axes.plot(yw, zw + 0.6, color="black", linewidth=1.2)
    axes.annotate("upper body (wheel)", (0, 4.6), ha="center")
    axes.annotate("lower body (rail)", (0, -9), ha="center")
    for at in (-6.0, 0.0, 7.0):
        local_directions(axes, lower, at)
    axes.annotate("s = 0", (0, -1.1), ha="center", fontsize=9)
    draw_inclination(axes, lower, 7.0)
    start = np.array([-20.0, -8.0])
    arrow(axes, start, np.array([2.4, 0]), "dimgrey", "y")
    arrow(axes, start, np.array([0, 2.4]), "dimgrey", "z")
    axes.plot(*start, "o", color="dimgrey", markersize=9, mfc="white")
    axes.plot(*start, ".", color="dimgrey")
    axes.annotate("x: towards you\n(rolling)", start - np.array([0.8, 2.4]), color="dimgrey", fontsize=9)
    axes.set(xlim=(-21.4, 14.5), ylim=(-11, 6.0))
    axes.set_aspect("equal")
    axes.axis("off")
    return figure


def local_directions(axes: Axes, contour: Contour, s: float) -> None:
    """Draw s and n at a place of a contour."""
    place = np.array(contour.position(np.array(s)))
    delta = float(contour.inclination(np.array(s)))
    along, normal = np.array([np.cos(delta), -np.sin(delta)]), np.array([np.sin(delta), np.cos(delta)])
    arrow(axes, place, 2.6 * along, BLUE)
    axes.annotate("s", place + 2.5 * along - 0.75 * normal, color=BLUE, ha="center", va="center")
    arrow(axes, place, 2.6 * normal, RED, "n")
    axes.plot(*place, "o", color="black", markersize=4)


def draw_inclination(axes: Axes, contour: Contour, s: float) -> None:
    """Draw the angle between the horizontal and the direction s at a place of a contour."""
    place = np.array(contour.position(np.array(s)))
    delta = float(np.rad2deg(contour.inclination(np.array(s))))
    axes.plot(
        *np.transpose([place, place + np.array([3.0, 0.0])]), color="black", linewidth=0.8, linestyle="--"
    )
    axes.add_patch(Arc(place, 4.2, 4.2, theta1=-delta, theta2=0.0))
    axes.annotate(f"δ = {delta:.0f}°", place + np.array([2.2, 0.35]), fontsize=9)


def engines() -> Figure:
    """Draw the mesh of a section, whole and near the load."""
    body = Body(LOWER, arc(10.0, STEEP, STEEP), STEEL, Domain(320.0, np.inf))
    section = section_mesh(body, SectionSize(Cells(0.1, 0.35, 0.35), np.array([[-0.2, 0.2]])))
    corners = section.mesh.p[:, section.mesh.t[:3]].transpose(2, 1, 0)
    figure = Figure((7.6, 3.6), layout="constrained")
    for axes, reach, title in zip(
        figure.subplots(1, 2),
        (330.0, 3.0),
        ("whole section, clamped on the far arc", "at the load"),
        strict=True,
    ):
        axes.add_collection(PolyCollection(corners, facecolor=RAIL, edgecolor="black", linewidth=0.35))
        axes.set(xlim=(-reach, reach), ylim=(-1.05 * reach, 0.12 * reach), xlabel="y [mm]", ylabel="z [mm]")
        axes.set_aspect("equal")
        axes.set_title(f"{title}", fontsize=10)
    axes.plot([-0.2, 0.2], [0, 0], color=RED, linewidth=4, solid_capstyle="butt")
    return figure


def discount() -> Figure:
    """Draw C_nn of a rail along s before and after the discount, with two far arcs."""
    figure = Figure((7.2, 3.2), layout="constrained")
    axes = figure.subplots()
    steel = femic.Material(E=210e3, nu=0.28)
    rail = femic.Body(femic.arc(10.0, 60.0), steel)
    pair, patch = femic.Pair(femic.Body(femic.plane(), steel), rail), femic.Patch(a=0.2, b=0.2)
    line = [femic.line_along_s(x=0.8, reach=12.0, points=121)]
    options = femic.Options(tolerance=0.03)
    ics = femic.compute_ics(
        pair, patch, line, ["A", "C"], bodies=["lower"], components=["nn"], options=options
    )
    c = ics.sel(body="lower", i="n", j="n")
    axes.plot(c.s, 1e6 * c.ic.sel(variant="C"), color="black", label="C, after the discount")
    axes.plot(
        c.s,
        1e6 * ics.raw.sel(solved="lower", i="n", j="n"),
        color=RED,
        label="before, with the rigid motion",
    )
    axes.plot(c.s, 1e6 * c.ic.sel(variant="A"), color=BLUE, linestyle="--", label="A, the half-space")
    axes.set(xlabel="s [mm]", ylabel="$C_{nn}$ [1e-6 mm/N]", xlim=(-12, 12))
    axes.grid(alpha=0.3)
    axes.legend(frameon=False)
    return figure


def approximations() -> Figure:
    """Draw which directions A, B, B-bar and B-hat give load and displacement."""
    figure = Figure((9.6, 2.9), layout="constrained")
    contour = arc(10.0, STEEP, STEEP)
    turns = {"A": (0.0, 0.0), "B": (1.0, 0.0), "B̄": (0.0, 1.0), "B̂": (0.5, 0.5)}
    s_load, s_read = -5.0, 5.0
    for axes, (name, (load, read)) in zip(figure.subplots(1, 4), turns.items(), strict=True):
        s = np.linspace(-10, 10, 201)
        y, z = contour.position(s)
        axes.fill_between(y, z, -7, color=RAIL)
        axes.plot(y, z, color="black", linewidth=1)
        for at, share, colour, sign, text in ((s_load, load, RED, -1, "J"), (s_read, -read, BLUE, 1, "I")):
            place = np.array(contour.position(np.array(at)))
            own = float(contour.inclination(np.array(at)))
            turned = own + share * float(
                contour.inclination(np.array(s_read)) - contour.inclination(np.array(s_load))
            )
            for delta, look in ((own, "lightgrey"), (turned, colour)):
                along = 2.9 * np.array([np.sin(delta), np.cos(delta)])
                arrow(axes, place if sign > 0 else place + along, along if sign > 0 else -along, look)
            axes.annotate(text, place, xytext=(0, -12), textcoords="offset points", ha="center", color=colour)
        axes.set_title(name)
        axes.set(xlim=(-9, 9), ylim=(-7, 4))
        axes.set_aspect("equal")
        axes.axis("off")
    return figure


def sn() -> Figure:
    """Draw the displacement along s of two bodies together under a load along n (Geometry 1)."""
    pair, patch = femic.load_pair("geometry1"), femic.Patch(a=0.2, b=0.2)
    line = [femic.line_along_s(x=1.6, reach=20.0, points=201)]
    ics = femic.compute_ics(
        pair,
        patch,
        line,
        list(LOOKS),
        bodies=["combined"],
        components=["sn"],
        options=femic.Options(store=STORE),
    )
    figure = Figure((6.4, 3.6), layout="constrained")
    axes = figure.subplots()
    curves = 1e6 * ics.ic.sel(body="combined", i="s", j="n")
    for name, (label, colour, dashes) in LOOKS.items():
        axes.plot(curves.s, curves.sel(variant=name), color=colour, linestyle=dashes, label=label)
    axes.set(xlabel="s [mm]", ylabel="displacement along s\nper load along n [1e-6 mm/N]", xlim=(-20, 20))
    axes.grid(alpha=0.3)
    axes.legend(frameon=False)
    return figure


def corner() -> Figure:
    """Draw the pressures of the first contact of the docs."""
    steel = femic.Material(E=210e3, nu=0.28)
    rail = femic.Body(femic.arc(10.0, flank_inclination_deg=60.0), steel)
    wheel = femic.Body(femic.arc(10.2, flank_inclination_deg=60.0), steel, rolling_radius=460.0)
    motion = femic.Frictionless(loads=[20e3, 100e3])
    options = femic.Options(store=STORE)
    return pressures(femic.solve_contact(femic.Pair(wheel, rail), motion, options=options))


def tall() -> Figure:
    """Draw the pressures of the scene `tall`."""
    motion = femic.Frictionless(loads=[7.4e3, 58e3, 310e3])
    options = femic.Options(tolerance=0.03, store=STORE)
    setup = femic.ContactSetup(flanks=False)
    return pressures(femic.solve_contact(femic.load_pair("tall"), motion, setup=setup, options=options))


def pressures(contact: xr.Dataset) -> Figure:
    """Draw the pressures [MPa] across the patch at x = 0, a panel for each load."""
    cases = contact.sizes["case"]
    figure = Figure((3.1 * cases, 3.3), layout="constrained")
    for number, axes in enumerate(figure.subplots(1, cases)):
        s = contact[f"s_{number}"]
        across = contact[f"p_{number}"].interp({f"x_{number}": 0.0})
        for name in ("A", "Bhat", "C"):
            label, colour, dashes = LOOKS[name]
            axes.plot(s, across.sel(ics=name), color=colour, linestyle=dashes, label=label)
        load, angle = contact["load"][number].max().item(), contact.angle.sel(ics="C")[number].item()
        reach = 1.15 * contact.b[number].max().item()
        axes.set(xlabel="s [mm]", xlim=(-reach, reach), ylim=(0, None))
        axes.set_title(f"{load / 1e3:g} kN, {angle:.0f}°", fontsize=10)
        axes.grid(alpha=0.3)
    figure.axes[0].set_ylabel("pressure [MPa]")
    figure.legend(*axes.get_legend_handles_labels(), loc="outside lower center", ncols=3, frameon=False)
    return figure


PICTURES: dict[str, Callable[[], Figure]] = {
    "ic": ic,
    "frames": frames,
    "engines": engines,
    "discount": discount,
    "approximations": approximations,
    "sn": sn,
    "corner": corner,
    "tall": tall,
}

if __name__ == "__main__":
    main()
