"""Charts of contacts: pressures and numbers over the angle of the patch, patches, pressures on the rail."""

from collections.abc import Mapping, Sequence

import numpy as np
import xarray as xr
from contourpy import contour_generator

from compare.pages.contact_numbers import case_labels, differences, largest_case, tolerance_levels
from compare.report.charts import Chart, Curve, Map, Panel, Surface, simple_chart
from compare.report.looks import drawing_order, ics_looks, ics_symbol, without_marker
from compare.report.tables import Column
from femic.contact.pairs.quantities import OF_FRICTIONLESS
from femic.results.contact import compared_ics, ics_names, pressures, reference_ics
from geometries.arrays import Array, Mask
from geometries.patches import N
from geometries.surfaces import Surface as BodySurface

MAIN = ("p_max", "b")  # quantities over the angle of the patch, beside the pressures
FURTHER = ("a", "aspect", "approach", "stiffness")
RELIEF = 0.2  # drawn height of the largest pressure over the grid's width
LIFTED = 0.02  # drawn height of pressures of 0 over the height of the largest
MOST = 40  # points of a drawing in 3D along x and along s
LOAD = "load"  # the name of sliders
Line = tuple[Array, Array]  # arc lengths [mm] and pressures [MPa], (n,)

# --- pressures along s, and numbers over the angle ------------------------------------------------------


def answer_chart(dataset: xr.Dataset) -> Chart:
    """Return pressures across the patch by load beside numbers over the angle; differences below them."""
    reference, profiles = reference_ics(dataset), {}
    for number, label in enumerate(case_labels(dataset)):
        p = pressures(dataset, number)
        middle = p.sizes["x"] // 2
        with_reference = p.sel(ics=reference).values
        at = middle if (with_reference[middle] > 0).any() else int(np.argmax(with_reference.max(axis=1)))
        place = "x = 0" if at == middle else f"x = {float(p.x[at]):.2g} mm"
        across = p.isel(x=at)
        part = loaded_part(across)
        s = across.s.values[part]
        lines = {name: (s, across.sel(ics=name).values[part]) for name in ics_names(dataset)}
        apart = {name: (s, own - lines[reference][1]) for name, (_, own) in lines.items()}
        angle = float(dataset.angle.sel(ics=reference)[number])
        title = f"pressure at {place}; the surface turns by {angle:.0f}°"
        panels = profile_panels(title, lines, apart, reference)
        profiles[label] = panels if len(lines) > 1 else panels[:1]
    return beside_numbers(dataset, profiles, reference)


def beside_numbers(dataset: xr.Dataset, profiles: Mapping[str, Sequence[Panel]], reference: str) -> Chart:
    """Return profiles and their differences, by load, beside the main numbers over the angle.

    A single case has no numbers over an angle.
    """
    above, below = over_angle(dataset, MAIN, reference) if len(profiles) > 1 else ([], [])
    steps = {label: [first, *above, *rest, *below] for label, (first, *rest) in profiles.items()}
    alt = "pressures across the patch, p_max and half-width with each of the ICs, and their differences"
    columns = 1 + len(above) if above else 2
    return Chart("answer", steps, columns, LOAD, 0.78, _start(dataset, reference), alt=alt)


def _start(dataset: xr.Dataset, reference: str) -> str:
    """Return the case that charts show first, the one that the summary is about."""
    return case_labels(dataset)[largest_case(dataset, reference)]


def over_angle(dataset: xr.Dataset, keys: Sequence[str], reference: str) -> tuple[list[Panel], list[Panel]]:
    """Return numbers over the angle of the patch with the reference, and their differences to it, if any.

    Cases that the reference has no solution of are left out.
    """
    cases = dataset.isel(case=dataset.angle.sel(ics=reference).notnull().values)
    cases = cases.isel(case=np.argsort(cases.angle.sel(ics=reference).values))
    angle = cases.angle.sel(ics=reference).values
    looks = ics_looks(ics_names(dataset))
    across, above, below = f"Δδ with {ics_symbol(reference)} [deg]", [], []
    for key in keys:
        (off, known), estimate = differences(cases, key, reference), cases[f"estimate_{key}"]
        values, apart = [], []
        for name in drawing_order(looks):
            curve, is_reference = (ics_symbol(name), angle), name == reference
            band = estimate.sel(ics=name) if is_reference else None
            values.append(Curve(*curve, cases[key].sel(ics=name), looks[name], band))
            bars = None if is_reference else known.sel(ics=name)
            apart.append(Curve(*curve, off.sel(ics=name), looks[name], bars, bars=True))
        quantity = OF_FRICTIONLESS[key]
        title = f"{quantity.symbol} against the angle"
        above.append(Panel(title, across, Column(quantity.symbol, quantity.unit).title, values))
        difference = f"{quantity.symbol}: difference from {ics_symbol(reference)}"
        levels = tolerance_levels(dataset)
        below.append(Panel(difference, across, f"difference of {quantity.symbol} [%]", apart, levels=levels))
    return above, below if len(looks) > 1 else []


def numbers_chart(dataset: xr.Dataset, keys: Sequence[str], reference: str, name: str) -> Chart:
    """Return numbers over the angle of the patch, and below them their differences to the reference."""
    above, below = over_angle(dataset, keys, reference)
    return simple_chart(name, [*above, *below], len(keys))


def profile_panels(
    title: str, by_ics: Mapping[str, Line], differences: Mapping[str, Line], reference: str
) -> list[Panel]:
    """Return panels of pressures along s with ICs, by name, and of their differences to the reference."""
    looks, symbol = ics_looks(by_ics), ics_symbol(reference)
    upper, lower = (
        [Curve(ics_symbol(name), *lines[name], looks[name]) for name in drawing_order(lines)]
        for lines in (by_ics, differences)
    )
    return [
        Panel(title, "s [mm]", "p [MPa]", upper),
        Panel(f"pressure: difference from {symbol}", "s [mm]", f"p minus p with {symbol} [MPa]", lower),
    ]


def loaded_part(p: xr.DataArray) -> slice:
    """Return where along s any of the ICs has pressures, (ics, s), with an element on each side."""
    return _around((p > 0).any("ics").values)


def _around(loaded: Mask) -> slice:
    """Return the range of what is true, (n,), with one more on each side."""
    at = np.flatnonzero(loaded)
    return slice(max(at[0] - 1, 0), at[-1] + 2)


# --- patches --------------------------------------------------------------------------------------------


def surfaces(dataset: xr.Dataset) -> Chart:
    """Return pressures of the reference on the developed surface, with contact edges of all ICs."""
    labels = case_labels(dataset)
    steps = {label: patch_maps(dataset, number)[:1] for number, label in enumerate(labels)}
    return Chart("patches", steps, min(len(labels), 3), LOAD)


def patches(dataset: xr.Dataset) -> Chart:
    """Return the same by load."""
    return _by_load(dataset, "patches", slice(1), 1)


def pressure_differences(dataset: xr.Dataset) -> Chart:
    """Return by load how far the pressures with other ICs are from the reference's."""
    return _by_load(dataset, "differences", slice(1, None), min(len(compared_ics(dataset)), 3))


def _by_load(dataset: xr.Dataset, name: str, part: slice, columns: int) -> Chart:
    labels, start = case_labels(dataset), _start(dataset, reference_ics(dataset))
    steps = {label: patch_maps(dataset, number)[part] for number, label in enumerate(labels)}
    return Chart(name, steps, columns, LOAD, start=start, alt=f"{name} on the developed surface")


def patch_maps(dataset: xr.Dataset, number: int) -> list[Map]:
    """Return the pressures of a case with the reference, and the differences to them with other ICs."""
    p, reference, looks = _on_patch(dataset, number), reference_ics(dataset), ics_looks(ics_names(dataset))
    x, s, exact = p.x.values, p.s.values, p.sel(ics=reference)
    edges = [
        Curve(ics_symbol(name), *edge(x, s, p.sel(ics=name).values > 0), without_marker(looks[name]))
        for name in drawing_order(looks)
    ]
    symbol, across, up = ics_symbol(reference), "x [mm]", "s [mm]"
    title = f"pressure with {symbol}, patch edges with all ICs"
    maps = [Map(title, across, up, x, s, exact.where(exact > 0).values, "MPa", curves=edges)]
    largest = max(float(abs(p - exact).max()), np.finfo(float).tiny)
    for name in compared_ics(dataset):
        own = p.sel(ics=name)
        difference = (own - exact).where((own > 0) | (exact > 0)).values
        title, limits = f"pressure with {ics_symbol(name)} minus {symbol}", (-largest, largest)
        maps.append(Map(title, across, up, x, s, difference, "MPa", "diverging", limits))
    return maps


def _on_patch(dataset: xr.Dataset, number: int) -> xr.DataArray:
    """Return the pressures of a case about the patches of all ICs, (ics, x, s)."""
    p = pressures(dataset, number)
    loaded = (p > 0).any("ics")
    return p.isel(x=_around(loaded.any("s").values), s=_around(loaded.any("x").values))


def edge(x: Array, s: Array, inside: Mask) -> tuple[Array, Array]:
    """Return the line about the elements that are inside, (n_x, n_s); its parts are separated by NaN."""
    if not inside.any():
        return np.array([np.nan]), np.array([np.nan])
    lines = contour_generator(x, s, inside.T.astype(float)).lines(0.5)
    parts = [np.concatenate([line, [[np.nan, np.nan]]]) for line in lines]
    x_of_edge, s_of_edge = np.concatenate(parts)[:-1].T
    return x_of_edge, s_of_edge


def on_rail(dataset: xr.Dataset, lower: BodySurface) -> Chart:
    """Return pressures with the reference on the lower surface, as heights and colours, by load."""
    reference, steps = reference_ics(dataset), dict[str, list[Surface]]()

    def points(x: Array, s: Array) -> Array:
        """Return points of a grid on the surface, (3, n_x, n_s)."""
        position = lower.position(*map(np.ravel, np.meshgrid(x, s, indexing="ij")))
        return np.reshape(position, (3, len(x), len(s)))

    for number, label in enumerate(case_labels(dataset)):
        whole, on_patch = pressures(dataset, number), _on_patch(dataset, number)
        body = points(whole.x.values[[0, -1]], np.linspace(*lower.contour.limits, 60))
        p = on_patch.sel(ics=reference)
        p = p.isel({name: slice(None, None, -(-size // MOST)) for name, size in p.sizes.items()})
        x, s = p.x.values, p.s.values
        height = RELIEF * np.ptp(whole.s.values) * (p.values / float(p.max()) + LIFTED)
        raised = points(x, s) + height * lower.axes(0.0, s)[N][:, None]
        title = f"pressure with {ics_symbol(reference)}"
        steps[label] = [Surface(title, body, raised, p.where(p > 0).values, "p [MPa]")]
    return Chart("rail", steps, 1, LOAD, start=_start(dataset, reference), alt="pressures on the rail in 3D")
