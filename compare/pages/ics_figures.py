"""Figures of ICs along lines: curves, and their differences from C."""

import json
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import replace
from itertools import chain, product

import numpy as np
import xarray as xr

from compare.report.charts import MOST_MARKERS, Chart, Curve, Panel, mark_points, simple_chart
from compare.report.looks import Look, drawing_order, ics_looks, ics_symbol
from compare.report.thinning import thin_together

INVISIBLE = 1e-9  # dimensionless IC below which a curve is rounding
ESTIMATES = {"C": "estimate", "C_solid": "estimate_solid"}  # variables with the errors of both engines
RESOLUTION = 1000  # of the ordinates of a panel: finer details are not drawn
MIRRORED = 1e-6  # largest asymmetry of mirrored curves, as a share of the largest value on their line
OVERLAID_VARIANTS = ("A", "B", "Bhat")  # drawn of several scenes; tables also have the others
DASHES = ("solid", "dash", "dot", "dashdot", "longdash")  # of the scenes
WIDE_LINE, NARROW_LINE = 3.2, 1.2  # line widths, rear to front: curves that coincide stay visible


def combined_first(bodies: Iterable[str]) -> list[str]:
    """Return bodies in their order, but both together first."""
    return sorted(map(str, bodies), key=lambda body: body != "combined")


def main_body(bodies: Iterable[str]) -> str:
    """Return the body that pages speak of: both together, or else the first."""
    return combined_first(bodies)[0]


def components_in(ics: xr.Dataset) -> list[str]:
    """Return the components that a scene compares."""
    return list(json.loads(ics.attrs["components"]))


def lines_in(ics: xr.Dataset) -> list[str]:
    """Return the names of the lines in their order."""
    return list(dict.fromkeys(map(str, ics.line.values)))


def _first_component(components: Sequence[str]) -> str:
    return "nn" if "nn" in components else components[0]


def chart(scenes: Mapping[str, xr.Dataset]) -> Chart:
    """Return ICs of scenes on the main line, and their differences from C, a step per component.

    Halves of lines that repeat the other half in all scenes are left out.
    """
    ics = next(iter(scenes.values()))
    body, line = main_body(ics.body.values), main_line(ics)
    steps = {component: _with_differences(scenes, body, line, component) for component in components_in(ics)}
    return Chart("curves", steps, 2, "component", start=_first_component(components_in(ics)))


def further_chart(scenes: Mapping[str, xr.Dataset]) -> Chart:
    """Return the same on the other lines, and the ICs of the other bodies on the main line."""
    ics = next(iter(scenes.values()))
    (body, *others), line = combined_first(ics.body.values), main_line(ics)
    steps = {}
    for component in components_in(ics):
        on_others = [_with_differences(scenes, body, one, component) for one in lines_in(ics) if one != line]
        of_others = [
            _panel(f"{other}, {line}", _parts(scenes, other, line, component), _looks(scenes))
            for other in others
        ]
        steps[component] = [*chain.from_iterable(on_others), *of_others]
    return Chart(
        "further_curves", steps, 2, "component", heights=0.75, start=_first_component(components_in(ics))
    )


def main_line(ics: xr.Dataset) -> str:
    """Return the line that pages show first: the first one across the bodies, or else the first."""
    across = [line for line in lines_in(ics) if np.ptp(ics.s.values[ics.line.values == line]) > 0]
    return [*across, *lines_in(ics)][0]


def _with_differences(scenes: Mapping[str, xr.Dataset], body: str, line: str, component: str) -> list[Panel]:
    """Return the panel of ICs of scenes on a line, and that of their differences from C."""
    parts, looks, title = _parts(scenes, body, line, component), _looks(scenes), f"{body}, {line}"
    minus_c = {n: one.assign(ic=one.ic - one.ic.sel(variant="C", drop=True)) for n, one in parts.items()}
    differences = _panel(f"{title}: minus C", minus_c, looks)
    return [_panel(title, parts, looks), replace(differences, up=f"Δ{differences.up}")]


def _parts(scenes: Mapping[str, xr.Dataset], body: str, line: str, component: str) -> dict[str, xr.Dataset]:
    """Return a component of a body on a line by scene; the half of it where the other half repeats it."""
    parts = {n: along_line(one, line, body, component, len(scenes) > 1) for n, one in scenes.items()}
    if all(is_mirrored(one, line) for one in scenes.values()):
        return {n: part.isel(point=part["at"].values >= 0) for n, part in parts.items()}
    return parts


def component_chart(ics: xr.Dataset, component: str) -> Chart:
    """Return one component of labelled ICs, dimensionless: a row per body, a column per line."""
    lines, length = lines_in(ics), f",  L = {ics.reference_length:g} mm"
    looks = _looks({"": ics})
    panels = [
        _panel(f"{component}, {body}, {line}", {"": along_line(ics, line, body, component, True)}, looks)
        for body, line in product(map(str, ics.body.values), lines)
    ]
    return simple_chart(
        "curves", [replace(panel, across=panel.across + length) for panel in panels], len(lines)
    )


def along_line(ics: xr.Dataset, line: str, body: str, component: str, dimensionless: bool) -> xr.Dataset:
    """Return a component of a body along a line, and its estimates, over the coordinate `at`.

    Attributes name the axes and have the value that is rounding. Units: mm and µm/kN, or dimensionless.
    """
    scale = ics.reference_E * ics.reference_length
    unit, length = (scale, ics.reference_length) if dimensionless else (1e6, 1.0)
    on_line = ics.isel(point=np.flatnonzero(ics.line.values == line))
    along = "x" if np.ptp(on_line.s.values) == 0 else "s"
    names = [name for name in ("ic", *ESTIMATES.values()) if name in ics]
    part = on_line[names].sel(body=body, i=component[0], j=component[1]) * unit
    at = on_line[along].values / length
    bodies = json.loads(ics.attrs.get("bodies", "{}")).values() if along == "s" and not dimensionless else ()
    return part.assign_coords(at=("point", at)).assign_attrs(
        across=f"{along} / L  [-]" if dimensionless else f"{along} [mm]",
        up=f"{component} · E · L  [-]" if dimensionless else f"{component} [µm/kN]",
        least=INVISIBLE * unit / scale,
        marks=sorted({round(s, 9) for body in bodies for s in body["joints"]}),
    )


def is_mirrored(ics: xr.Dataset, line: str) -> bool:
    """Whether the two halves of a line have the same values, up to the sign, in all curves of a scene."""
    on_line = ics.isel(point=np.flatnonzero(ics.line.values == line))
    if np.ptp(on_line.s.values) == 0:
        return True  # every body and every load is symmetric in x
    s = on_line.s.values
    sizes = np.stack([abs(on_line.ic.sel(i=c[0], j=c[1]).values) for c in components_in(ics)])
    asymmetry = np.nanmax(np.abs(sizes - sizes[..., ::-1]))
    return np.allclose(s, -s[::-1]) and bool(asymmetry <= MIRRORED * np.nanmax(sizes))


def drawn_variants(ics: xr.Dataset, *, several: bool) -> list[str]:
    """Return the variants of a scene; of several those of `OVERLAID_VARIANTS`, if there are any, and C."""
    names = [str(name) for name in ics.variant.values]
    overlaid = [name for name in names if name in OVERLAID_VARIANTS]
    return [*overlaid, "C"] if overlaid and several else names


def _looks(scenes: Mapping[str, xr.Dataset]) -> dict[tuple[str, str], Look]:
    """Return looks by variant and scene, from the curves at the bottom to those on top.

    Variants have colours; of several scenes, these have dashes, and wide lines lie behind narrow ones.
    """
    variants = drawn_variants(next(iter(scenes.values())), several=len(scenes) > 1)
    looks = ics_looks(variants)
    if len(scenes) == 1:
        return {(variant, name): looks[variant] for name in scenes for variant in drawing_order(variants)}
    widths = np.linspace(WIDE_LINE, NARROW_LINE, len(variants))
    return {
        (variant, name): Look(looks[variant].colour, dash, width=round(width, 2))
        for variant, width in zip(["C", *(v for v in variants if v != "C")], widths, strict=True)
        for name, dash in zip(scenes, DASHES, strict=False)
    }


def _panel(title: str, parts: Mapping[str, xr.Dataset], looks: Mapping[tuple[str, str], Look]) -> Panel:
    """Return the panel of ICs of `along_line` by scene; those that were not computed are left out.

    Lines have the points that one sees.
    """
    curves, part = [], next(iter(parts.values()))
    span = max(float(one.ic.max() - one.ic.min()) for one in parts.values())
    chosen = {name: _visible_points(one, max(span, part.least) / RESOLUTION) for name, one in parts.items()}
    for (variant, name), look in looks.items():
        part = parts[name].isel(point=chosen[name]) if look.dash else parts[name]
        values, estimate = part.ic.sel(variant=variant).values, ESTIMATES.get(variant)
        if not np.all(np.isnan(values)):
            band = part[estimate].values if estimate in part else None
            symbol = ics_symbol(variant)
            label = f"{symbol}, {name}" if len(parts) > 1 else symbol
            curves.append(mark_points(Curve(label, part["at"].values, values, look, band)))
    at = part["at"].values
    marks = [mark for mark in part.attrs.get("marks", ()) if at[0] <= mark <= at[-1]]
    return Panel(title, part.across, part.up, curves, marks=marks, least=part.least)


def _visible_points(part: xr.Dataset, resolution: float) -> list[int]:
    """Return the points that all curves and bands need; where each point has a marker, all of them."""
    if part.sizes["point"] <= MOST_MARKERS:
        return list(range(part.sizes["point"]))
    bands = [part[name].values for name in ESTIMATES.values() if name in part]
    return thin_together(
        part["at"].values, np.vstack([part.ic.transpose("variant", "point"), *bands]), resolution
    )
