"""Charts to explore: what `templates/explore.js` gives to Plotly, as JSON, and Plotly itself."""

import json
from base64 import b64encode
from collections import Counter
from collections.abc import Iterable, Iterator, Sequence
from html import escape
from importlib import resources
from typing import Any

import numpy as np
from contourpy import FillType, contour_generator
from jinja2.utils import htmlsafe_json_dumps
from markupsafe import Markup

from compare.report.charts import Chart, Contours, Curve, Map, Panel, Surface
from compare.report.thinning import thin
from geometries.arrays import Array

Trace = dict[str, Any]  # a trace of Plotly

HEIGHT = {Panel: 290, Map: 340, Surface: 520, Contours: 400}  # of a cell [px]
SEEN = 1 / 2000  # of the size of contours: what may be left out
TICKS = 8  # at most, on the longest axis of a drawing in 3D
DIGITS = 6  # of numbers that one reads one by one
CURVE_DIGITS, MAP_DIGITS = 4, 3  # of the range of long curves and of maps: less than a pixel, or a colour
LONG = 100  # points of a curve from which one reads its shape
EXACT = 1e15  # whole numbers below it are written as such
ROUNDING = 1e-12  # share of a number below which a range is rounding
SHARED = "x", "y", "z", "surfacecolor", "customdata"  # parts of traces that are written once for a chart
COLOURS = {"sequential": "Viridis", "diverging": "RdBu", "logarithmic": "RdBu", "positive": "YlOrRd"}
EYE = {"x": -1.2, "y": -1.2, "z": 1.1}  # whence a cube is seen
MOST_DECADES = 8  # with a tick each on a logarithmic axis


def libraries(charts: Sequence[Chart]) -> Markup:
    """Return what draws some charts: bundles of Plotly, compressed, in script elements.

    Only surfaces need the bundle for 3D. `templates/explore.js` unpacks a bundle before it draws with it.
    """
    kinds = {isinstance(cell, Surface) for chart in charts for cell in chart.cells}
    bundles = [name for name, in_3d in (("heatmap", False), ("gl3d", True)) if in_3d in kinds]
    elements = []
    for name in bundles:
        packed = (resources.files("compare.report") / "plotly" / f"{name}.js.gz").read_bytes()
        elements.append(
            f'<script type="application/gzip" id="plotly-{name}">{b64encode(packed).decode()}</script>'
        )
    return Markup("\n".join(elements))


def content(chart: Chart) -> dict[str, Any]:
    """Return what a page needs to draw a chart."""
    draw: dict[type, Any] = {Panel: _panel, Map: _map, Surface: _surface, Contours: _contours}
    return {
        "name": chart.name,
        "alt": chart.alt,
        "slider": chart.slider,
        "choice": chart.choice,
        "labels": list(chart.steps),
        "start": chart.first,
        "columns": chart.columns,
        "height": cell_height(chart),
        "legend": [
            {
                "label": label,
                "colour": look.colour,
                "dash": look.dash,
                "marker": look.marker,
                "width": look.width,
            }
            for label, look in chart.legend.items()
        ],
        "steps": [[draw[type(cell)](cell) for cell in cells] for cells in chart.steps.values()],
    }


def as_json(chart: Chart) -> Markup:
    """Return the content of a chart as JSON that may stand in a script element.

    Arrays that occur more than once are in a list, and where they occur is their number in it.
    """
    whole = content(chart)
    traces = [trace for cells in whole["steps"] for cell in cells for trace in cell["traces"]]
    places = [(trace, key, json.dumps(trace[key])) for trace in traces for key in SHARED if key in trace]
    counts = Counter(text for *_, text in places)
    numbers = {text: k for k, text in enumerate(text for text, count in counts.items() if count > 1)}
    for trace, key, text in places:
        if text in numbers:
            trace[key] = numbers[text]
    whole["arrays"] = [json.loads(text) for text in numbers]
    return htmlsafe_json_dumps(whole, ensure_ascii=False, allow_nan=False, separators=(",", ":"))


def cell_height(chart: Chart) -> int:
    """Return the height of each cell of a chart [px]."""
    return round(max(HEIGHT[type(cell)] for cell in chart.cells) * chart.heights)


def _plain(text: str) -> str:
    """Return a text that Plotly shows as it is; it has tags such as <b>, and places such as %{y}."""
    return escape(text, quote=False).replace("{", "&#123;").replace("\n", "<br>")


def _plain_each(texts: Iterable[str]) -> list[str]:
    return [_plain(text) for text in texts]


def _panel(panel: Panel) -> dict[str, Any]:
    """Return the traces and the layout of a panel."""
    traces = [trace for curve in panel.curves for trace in _curve(curve, panel)]
    if panel.names_y:
        traces = [trace | {"hovertemplate": "%{y}<extra>%{fullData.name}</extra>"} for trace in traces]
    layout = _axes(panel)
    for k, (axis, limits) in enumerate((("xaxis", panel.limits_x), ("yaxis", panel.limits_y))):
        if "dtick" in layout[axis]:
            values = np.concatenate([np.zeros(0), *(curve.points[k] for curve in panel.curves)])
            powers = np.log10(values[np.isfinite(values) & (values > 0)])
            decades = int(np.floor(powers.max()) - np.ceil(powers.min())) if powers.size else 1  # whole ones
            layout[axis]["dtick"] = max(1, -(-decades // MOST_DECADES))
            if decades < 1:
                del layout[axis]["dtick"]  # Plotly then labels ticks between powers of ten
        if limits is not None:
            layout[axis]["range"] = list(limits)
    layout["shapes"] = [
        {
            "type": "line",
            **{f"{axis}0": at, f"{axis}1": at, f"{other}0": 0, f"{other}1": 1, f"{other}ref": "paper"},
            "line": {"color": "grey", "dash": "dot", "width": 1},
        }
        for axis, other, places in (("x", "y", panel.marks), ("y", "x", panel.levels))
        for at in places
    ]
    if panel.vanishes:
        layout["yaxis"] |= {"range": [-panel.least, panel.least], "tickvals": [0.0]}
        middle = {"x": 0.5, "y": 0.7, "xref": "paper", "yref": "paper", "showarrow": False}
        layout["annotations"] = [{"text": "0 by symmetry", **middle}]
    if any(curve.notes for curve in panel.curves):
        layout["hovermode"] = "closest"
    return {"title": panel.title, "traces": traces, "layout": layout}


def _axes(cell: Panel | Map) -> dict[str, Any]:
    """Return the layout of the axes of a cell."""
    layout: dict[str, Any] = {}
    for axis, title, log, names in (
        ("xaxis", cell.across, cell.log_x, cell.names_x),
        ("yaxis", cell.up, cell.log_y, cell.names_y),
    ):
        layout[axis] = {"title": {"text": _plain(title)}}
        if names:
            layout[axis] |= {"tickvals": list(range(len(names))), "ticktext": _plain_each(names)}
        elif log:
            layout[axis] |= {"type": "log", "dtick": 1, "exponentformat": "power"}
    if cell.to_scale:
        layout["yaxis"] |= {"scaleanchor": "x", "constrain": "domain"}
        layout["xaxis"] |= {"constrain": "domain"}
    return layout


def _curve(curve: Curve, cell: Panel | Map | Contours) -> Iterator[Trace]:
    """Yield the band of a curve, and the curve, with bars, names and notes of its points."""
    (x, y), look = curve.points, curve.drawn_look
    least = cell.least if isinstance(cell, Panel) else 0.0
    logs = (False, False) if isinstance(cell, Contours) else (cell.log_x, cell.log_y)
    step_x, step_y = (
        None if log or len(x) <= LONG else _step(values, CURVE_DIGITS, at_least)
        for values, log, at_least in zip((x, y), logs, (0.0, least), strict=True)
    )
    group = {"legendgroup": curve.label, "showlegend": False}
    further: Trace = {}
    if curve.band is not None:
        low, high = curve.band_edges
        if curve.bars:
            bars = {"array": _numbers(high - y), "arrayminus": _numbers(y - low)}
            further["error_y"] = {"type": "data", "symmetric": False, "thickness": 1, "width": 3, **bars}
        else:
            known = np.isfinite(low) & np.isfinite(high)
            at, low, high = x[known], low[known], high[known]
            yield {
                "x": _numbers(np.append(at, at[::-1]), step_x),
                "y": _numbers(np.append(high, low[::-1]), step_y),
                "type": "scatter",
                "mode": "lines",
                "fill": "toself",
                "fillcolor": f"{curve.look.colour} faint",
                "line": {"width": 0},
                "hoverinfo": "skip",
                **group,
            }
    if curve.names:
        places = [f"{side} right" for side in curve.sides]
        further |= {"text": _plain_each(curve.names), "textposition": places, "textfont": {"size": 11}}
        further["cliponaxis"] = False
    if curve.notes:
        further |= {"customdata": _plain_each(curve.notes), "hovertemplate": "%{customdata}<extra></extra>"}
    modes = {"lines": look.dash, "markers": look.marker, "text": curve.names}
    yield {
        "x": _numbers(x, step_x),
        "y": _numbers(y, step_y),
        "type": "scatter",
        "mode": "+".join(mode for mode, drawn in modes.items() if drawn),
        "name": _plain(curve.label),
        "line": {"color": look.colour, "width": look.width, "dash": look.dash or "solid"},
        "marker": {"color": look.colour, "symbol": look.marker or "circle", "size": 9 if curve.notes else 6},
        "hovertemplate": "%{y:.4~g}" if curve.label else "%{y:.4~g}<extra></extra>",
        **further,
        **group,
    }


def _map(drawn: Map) -> dict[str, Any]:
    """Return the traces and the layout of a map."""
    values, low, high = drawn.values.T, *drawn.range
    shown: Trace = {"type": "heatmap", "x": _numbers(drawn.x), "y": _numbers(drawn.y), "hoverongaps": False}
    place = ", ".join(
        f"{_plain(title.split(' [', maxsplit=1)[0])} %{{{axis}{'' if names else ':.4~g'}}}"
        for title, axis, names in ((drawn.across, "x", drawn.names_x), (drawn.up, "y", drawn.names_y))
    )
    unit, number = _plain(drawn.unit), "customdata"
    if drawn.classes:
        shown |= _classes(values, drawn) | {"hovertemplate": f"{place}: %{{text}}<extra></extra>"}
    else:
        if drawn.scale == "positive":
            shown |= _positive(values, low, high)
        elif drawn.scale == "logarithmic":
            shown |= _logarithmic(values, high, drawn.decades)
        else:
            number = "z"
            shown |= {"z": _colours(values), "zmin": low, "zmax": high, "colorbar": {"thickness": 12}}
        shown["colorbar"] |= {"title": {"text": unit, "side": "top"}}
        shown["hovertemplate"] = f"{place}: %{{{number}:.4~g}} {unit}<extra></extra>"
        shown["colorscale"] = COLOURS[drawn.scale]
    traces = [shown, *(trace for curve in drawn.curves for trace in _curve(curve, drawn))]
    return {"title": drawn.title, "traces": traces, "layout": _axes(drawn) | {"hovermode": "closest"}}


def _classes(values: Array, drawn: Map) -> Trace:
    """Return the part of a trace for values 0, 1, ... of named kinds."""
    names, count = _plain_each(drawn.classes), len(drawn.classes)
    edges = [(drawn.colours[k], (k + end) / count) for k in range(count) for end in (0, 1)]
    ticks = {"tickvals": list(range(count)), "ticktext": names, "thickness": 12}
    scale = [[at, colour] for colour, at in edges]
    return {
        "z": _numbers(values),
        "kinds": names,
        "zmin": -0.5,
        "zmax": count - 0.5,
        "colorscale": scale,
        "colorbar": ticks,
    }


def _logarithmic(values: Array, largest: float, decades: float) -> Trace:
    """Return the part of a trace with logarithmic colours of both signs, linear below `decades`."""
    least = largest / 10**decades
    magnitude = np.log10(np.maximum(np.abs(values) / least, 1.0))
    powers = np.arange(int(decades) + 1)
    ticks = np.concatenate([-powers[:0:-1], powers])
    names = [f"{np.sign(k) * least * 10.0 ** abs(k):.0e}" if k else "0" for k in ticks]
    return {
        "z": _colours(np.sign(values) * magnitude),
        "customdata": _numbers(values, digits=CURVE_DIGITS),
        "zmin": -decades,
        "zmax": decades,
        "colorbar": {"tickvals": ticks.tolist(), "ticktext": names, "thickness": 12},
    }


def _positive(values: Array, low: float, high: float) -> Trace:
    """Return the part of a trace with colours by the logarithm between limits; more is darker."""
    powers = np.arange(np.ceil(np.log10(low)), np.floor(np.log10(high)) + 1)
    return {
        "z": _colours(np.log10(np.maximum(values, low))),
        "customdata": _numbers(values, digits=CURVE_DIGITS),
        "zmin": float(np.log10(low)),
        "zmax": float(np.log10(high)),
        "reversescale": True,
        "colorbar": {
            "tickvals": powers.tolist(),
            "ticktext": [f"{10**p:g}" for p in powers],
            "thickness": 12,
        },
    }


def _surface(surface: Surface) -> dict[str, Any]:
    """Return the traces and the layout of a surface in 3D."""
    grey = {"colorscale": [[0, "#b8bcc2"], [1, "#b8bcc2"]], "showscale": False, "hoverinfo": "skip"}
    lit = {"lighting": {"ambient": 0.65, "diffuse": 0.6, "specular": 0.05}}
    box = np.concatenate([points.reshape(3, -1) for points in (surface.body, surface.part)], axis=1)
    step = max(_step(points, CURVE_DIGITS) for points in box)  # all axes have the same scale
    x, y, z = surface.part
    empty = np.isnan(surface.values)
    part = x, np.where(empty, np.nan, y), np.where(empty, np.nan, z)
    at, on = (
        {axis: _numbers(points, step) for axis, points in zip("xyz", body, strict=True)}
        for body in (surface.body, part)
    )
    bar = {"title": {"text": _plain(surface.unit), "side": "top"}, "thickness": 14}
    pressed = {"surfacecolor": _colours(surface.values), "colorscale": "Viridis", "colorbar": bar}
    pressed["hovertemplate"] = "x %{x:.4~g}, y %{y:.4~g} mm: %{surfacecolor:.4~g}<extra></extra>"
    spans = np.ptp(box, axis=1)
    ticks = np.clip(np.ceil(TICKS * spans / np.max(spans)), 2, TICKS)  # short axes of a drawing get few
    positive = spans[spans > 0]
    slenderness = float(np.max(positive) / np.exp(np.mean(np.log(positive))))  # the mean is drawn as 1
    scene: dict[str, Any] = {
        f"{axis}axis": {"title": {"text": f"{axis} [mm]"}, "nticks": int(count)}
        for axis, count in zip("xyz", ticks, strict=True)
    }
    eye = {axis: slenderness**0.5 * place for axis, place in EYE.items()}
    return {
        "title": surface.title,
        "traces": [{"type": "surface", **at, **grey, **lit}, {"type": "surface", **on, **pressed, **lit}],
        "layout": {"scene": scene | {"aspectmode": "data", "camera": {"eye": eye}}},
    }


def _contours(drawn: Contours) -> dict[str, Any]:
    """Return the traces and the layout of contours: what exceeds each level is painted upon the rest.

    Points without size have the values that are read where one points at them, and the colour bar.
    """
    levels, colours, traces = drawn.levels, drawn.colours, []
    every = slice(None, None, drawn.stride)
    points = np.concatenate([points[:, every, every].reshape(2, -1) for points, _ in drawn.regions], axis=1)
    values = np.concatenate([values[every, every].ravel() for _, values in drawn.regions])
    known, size = np.isfinite(values), float(np.max(np.ptp(points, axis=1)))
    tolerance, digits = SEEN * size, 3 - int(np.floor(np.log10(size)))
    for (across, up), field in drawn.regions:
        generator = contour_generator(across, up, np.ma.masked_invalid(field), fill_type=FillType.OuterOffset)
        for level, colour in zip(levels[:-1], colours, strict=True):
            edges = [
                np.append(
                    np.stack(thin(part[:, 0], part[:, 1], tolerance), axis=1).round(digits),
                    [[np.nan, np.nan]],
                    axis=0,
                )
                for polygon, offsets in zip(*generator.filled(level, np.inf), strict=True)
                for part in np.split(polygon, offsets[1:-1])
            ]
            if edges:
                x, y = (_numbers(axis) for axis in np.concatenate(edges).T)
                traces.append(
                    {
                        **{"type": "scatter", "mode": "lines", "x": x, "y": y, "line": {"width": 0}},
                        **{"fill": "toself", "fillcolor": colour, "hoverinfo": "skip", "showlegend": False},
                    }
                )
    places = np.repeat(np.linspace(0.0, 1.0, len(levels)), 2)[1:-1]
    bar = {"title": {"text": _plain(drawn.unit), "side": "top"}, "thickness": 12, "tickvals": levels.tolist()}
    traces.append(
        {
            **{"type": "scatter", "mode": "markers", "showlegend": False},
            **{axis: _numbers(at[known].round(digits)) for axis, at in zip("xy", points, strict=True)},
            "marker": {
                **{"color": _numbers(values[known]), "opacity": 0, "showscale": True, "colorbar": bar},
                **{"cmin": float(levels[0]), "cmax": float(levels[-1])},
                "colorscale": [list(one) for one in zip(places, np.repeat(colours, 2), strict=True)],
            },
            "hovertemplate": f"(%{{x:.3~g}}, %{{y:.3~g}}) mm: %{{marker.color:.4g}} {_plain(drawn.unit)}"
            "<extra></extra>",
        }
    )
    outlines = [trace for curve in drawn.curves for trace in _curve(curve, drawn)]
    axis = {"constrain": "domain", "zeroline": False}
    layout = {
        "xaxis": axis | {"title": {"text": _plain(drawn.across)}},
        "yaxis": axis | {"title": {"text": _plain(drawn.up)}, "scaleanchor": "x"},
        "hovermode": "closest",
    }
    return {"title": drawn.title, "traces": traces + outlines, "layout": layout}


def _colours(values: Array) -> Any:
    """Return numbers that are shown by colours."""
    return _numbers(values, _step(values, MAP_DIGITS))


def _step(values: Array, digits: int, least: float = 0.0) -> float:
    """Return the power of ten to which numbers are rounded: some digits of their range, or of a least one.

    It is 0 where all numbers are 0. A small range of large numbers counts, unless it is rounding.
    """
    known = values[np.isfinite(values)]
    if not known.size:
        return 0.0
    step = max(10.0**-digits * max(np.ptp(known), least), ROUNDING * np.max(np.abs(known)))
    return float(10.0 ** np.floor(np.log10(step))) if step > 0 else 0.0


def _numbers(values: Array, step: float | None = None, digits: int = DIGITS) -> Any:
    """Return numbers as lists, None for NaN: multiples of a power of ten, or without one to some digits."""
    array = np.asarray(values, dtype=float)
    if array.ndim > 1:
        return [_numbers(row, step, digits) for row in array]
    if step:
        decimals = -round(np.log10(step))
        rounded = [round(float(v), decimals) for v in array]
    else:
        rounded = [float(f"{v:.{digits}g}") for v in array]
    return [(int(v) if v.is_integer() and abs(v) < EXACT else v) if np.isfinite(v) else None for v in rounded]
