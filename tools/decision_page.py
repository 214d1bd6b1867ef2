"""The figure, tables and texts of docs/decide/which-ics.md and docs/evidence/limits.md, from `decisions`."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any

import matplotlib as mpl
import numpy as np
from decisions import TOLERANCES, WIDEST, WITH_FRICTION
from matplotlib.figure import Figure
from matplotlib.lines import Line2D

from compare.report.charts import Curve, Panel, simple_chart
from compare.report.looks import OWN, Look, ics_symbol
from compare.report.static import RC, draw_panel, line_style

SHOWN = 0.05  # the tolerance whose crossings the figure marks
OF_RATIOS = {1.01: "#440154", 1.02: "#3b528b", 1.05: "#21918c", 1.1: "#5ec962", 1.25: "#e0b000"}
OTHERS = {
    "tall": Look("#d55e00", "solid", "", 2.2),
    "wide": Look("#cc79a7", "solid", "", 2.2),
    "s1002-on-60e1": Look("#808080", "solid", "", 2.2),
    "s1002-on-60e1-worn": Look("#808080", "dot", "", 2.2),
}
SPACE, PLUS_MINUS, DOTS = "\u00a0", "\u00a0±\u00a0", "\u00a0…\u00a0"  # lines do not break there
CROSSING = f"error reaches {100 * SHOWN:g} %"
CROSSED = Look("ink", "", "circle-open")
DRAWN, LOOSEST = "rolling", "arc-1.1"  # the pair whose forces are drawn, and the one that fits least
FORCE_ICS = ("A", "Bhat", "Bhat_prime", "mix")
OF_FRICTION = {"0.2": "solid", "0.4": "dash", "0.6": "dot"}


def draw(values: Mapping[str, Any]) -> Figure:
    """Return the decision figure: errors of p_max over the angle by pair, and of F_x by friction."""
    angle, pairs = "Δδ: angle of the patch with C [°]", values["pairs"].values()
    frictions = values["rolling"][DRAWN]["frictions"]
    levels = (-100 * SHOWN, 100 * SHOWN)
    pressures = [
        Panel(
            f"p_max with {ics_symbol(ics)}, without friction",
            angle,
            "error of p_max [%]",
            [curve for pair in pairs for curve in _pair_curves(pair, ics)]
            + _crossed([pair["crossings"][ics]["p_max"] for pair in pairs]),
            levels=levels,
        )
        for ics in ("A", "Bhat")
    ]
    forces = [
        Panel(
            title,
            angle,
            "error of F_x [% of friction × load]",
            [
                curve
                for friction in frictions
                for curve in _force_curves(frictions[friction], number, friction)
            ]
            + _crossed([of[number] for one in frictions.values() for of in one["crossings"].values()]),
            levels=levels,
        )
        for number, title in (
            ("half", "F_x at half the friction limit"),
            ("free", "F_x at free rolling"),
        )
    ]
    looks = {ics_symbol(ics): replace(OWN[ics], dash="solid", marker="") for ics in WITH_FRICTION}
    looks |= {f"friction {friction}": Look(dash=dash) for friction, dash in OF_FRICTION.items()}
    legends = simple_chart("", pressures).legend, looks | {CROSSING: CROSSED}
    with mpl.rc_context(RC):
        figure = Figure((8.4, 6.8), layout="constrained")
        for part, cells, legend in zip(figure.subfigures(2), (pressures, forces), legends, strict=True):
            for axes, cell in zip(part.subplots(1, 2), cells, strict=True):
                axes.set(title=cell.title, xlabel=cell.across, ylabel=cell.up)
                draw_panel(axes, cell)
            handles = [Line2D([], [], label=label, **line_style(look)) for label, look in legend.items()]
            part.legend(handles=handles, loc="outside lower center", ncols=4, fontsize=8)
    return figure


def _pair_curves(pair: Mapping[str, Any], ics: str) -> list[Curve]:
    errors = np.array(pair["errors"][ics]["p_max"])
    if pair["ratio"] is None:
        look = OTHERS[pair["name"]]
        label = pair["short"]
    else:
        wide = pair["flanks"] == WIDEST
        look = Look(OF_RATIOS[pair["ratio"]], "solid" if wide else "dash")
        label = pair["short"]
    return [Curve(label, pair["angles"], 100 * errors[:, 0], look, 100 * errors[:, 1])]


def _force_curves(solved: Mapping[str, Any], number: str, friction: str) -> list[Curve]:
    curves = []
    for ics, of in solved["errors"].items():
        errors = np.array(of[number])
        look = replace(OWN[ics], dash=OF_FRICTION[friction], marker="")
        curves.append(Curve(ics_symbol(ics), solved["angles"], 100 * errors[:, 0], look))
    return curves


def _crossed(crossings: Sequence[Mapping[str, Any]]) -> list[Curve]:
    """Return marks where errors pass the tolerance that the figure shows."""
    found = [of[f"{SHOWN:g}"] for of in crossings if f"{SHOWN:g}" in of]
    at = [one["at"] for one in found if one["at"] and not one["before"]]
    x, y = [one["angle"] for one in at], [100 * one["error"] for one in at]
    return [Curve(CROSSING, x, y, CROSSED)] if at else []


@dataclass(frozen=True)
class Wanted:
    """A number that one wants to a tolerance, in words, and its place among the numbers."""

    text: str
    number: str
    tolerance: float


PRESSURES = (
    *(Wanted(f"p_max to {100 * tolerance:g} %", "p_max", tolerance) for tolerance in TOLERANCES["p_max"]),
    Wanted("length a to 5 %", "a", 0.05),
    Wanted("width b to 5 %", "b", 0.05),
    Wanted("approach to 5 %", "approach", 0.05),
)
FORCES = (
    Wanted("F_x to 2.5 %, at half the friction limit", "half", 0.025),
    Wanted("F_x to 5 %, at half the friction limit", "half", 0.05),
    Wanted("F_x to 5 %, at free rolling", "free", 0.05),
)


LOOSE = "arc-1.1"  # of the pairs with friction


def decision_rows(values: Mapping[str, Any]) -> list[dict[str, Any]]:
    """Return the rows of the decision table: what is wanted, and how far each of some ICs is good enough.

    Forces depend on the fit most of all: loose pairs have rows of their own.
    """
    pairs = list(values["pairs"].values())
    frictions: dict[bool, list[Any]] = {False: [], True: []}  # by whether the pair is loose
    for name, pair in values["rolling"].items():
        frictions[name == LOOSE] += pair["frictions"].values()
    groups = [("", pairs, PRESSURES)] + [
        (f"{fit}: ", frictions[loose], FORCES)
        for fit, loose in (("close fit", False), ("loose fit (1 : 1.1)", True))
        if frictions[loose]
    ]
    return [
        {"wanted": fit + wanted.text} | {ics: reach(of, ics, wanted) for ics in FORCE_ICS}
        for fit, of, rows in groups
        for wanted in rows
    ]


def reach(solved: Sequence[Mapping[str, Any]], ics: str, wanted: Wanted) -> str:
    """Return up to which angle some ICs are good enough: at worst and at best of the pairs, or frictions."""
    if any(ics not in one["crossings"] for one in solved):
        return ""
    found = [one["crossings"][ics][wanted.number][f"{wanted.tolerance:g}"] for one in solved]
    crossed = sorted((of["at"]["angle"], number) for number, of in enumerate(found) if of["at"])
    ends = [of["end"]["angle"] for of in found if not of["at"]]
    if not crossed:
        return f"met{SPACE}up{SPACE}to{SPACE}{max(ends):.0f}°"
    first, last = (crossing_text(found[number]) for _, number in (crossed[0], crossed[-1]))
    if ends and max(ends) > crossed[-1][0]:
        return f"{first}°{DOTS}>{SPACE}{max(ends):.0f}°"
    return f"{first}°" if first == last else f"{first}°{DOTS}{last}°"


def crossing_text(found: Mapping[str, Any]) -> str:
    """Return the angle of a crossing and its estimated error [deg]; a dash where there is none."""
    if found["at"] is None:
        return "–"
    angle = f"{found['at']['angle']:.0f}"
    if found["before"]:
        return f"<{SPACE}{angle}"
    return f"{angle}{PLUS_MINUS}{np.ceil(found['estimate']):.0f}" + ("" if found["stays"] else " †")


def error_text(deviation: Mapping[str, float]) -> str:
    """Return an error with its estimated error [%]; one that rounds to 0 is within ± this."""
    text = signed(deviation["error"])
    return f"{'within' if text == '0.0' else text}{PLUS_MINUS}{max(100 * deviation['estimate'], 0.1):.1f}"


def signed(share: float) -> str:
    """Return a share in percent with its sign; zero has none."""
    text = f"{100 * share:+.1f}".replace("-", "−")
    return "0.0" if float(f"{100 * share:.1f}") == 0 else text


def nearest(values: Mapping[str, Any], name: str, key: str, place: float) -> dict[str, Any]:
    """Return the errors of a pair where angles or loads are nearest a place; rolling: "PAIR FRICTION"."""
    if name in values["pairs"]:
        solved = values["pairs"][name]
    else:
        pair, friction = name.rsplit(maxsplit=1)
        solved = values["rolling"][pair]["frictions"][friction]
    k = int(np.argmin(np.abs(np.array(solved[key]) - place)))
    return {
        "title": solved.get("title", ""),
        "load": solved["loads"][k],
        "angle": solved["angles"][k],
        "errors": {
            ics: {number: {"error": row[k][0], "estimate": row[k][1]} for number, row in of.items()}
            for ics, of in solved["errors"].items()
        },
    }


def force_rows(values: Mapping[str, Any]) -> list[dict[str, Any]]:
    """Return the rows of the tables of F_x, by pair and friction, one text for each of the ICs.

    Where errors reach two tolerances, and the errors at the largest load, as shares of friction times load.
    """
    rows = []
    for name, pair in values["rolling"].items():
        for friction, of in pair["frictions"].items():
            at = nearest(values, f"{name} {friction}", "angles", 180.0)
            errors = [at["errors"][ics][number] for number in ("half", "free") for ics in FORCE_ICS]
            rows.append(
                {
                    "name": f"{pair['short']}, {friction}",
                    "at_largest": f"{pair['short']}, {at['angle']:.0f}°, {friction}",
                    "half": _reached(of, "half", ("0.025", "0.05")),
                    "free": _reached(of, "free", ("0.05", "0.1")),
                    "errors": [signed(one["error"]) for one in errors],
                    "estimate": f"{max(100 * max(one['estimate'] for one in errors), 0.1):.1f}",
                }
            )
    return rows


def _reached(of: Mapping[str, Any], number: str, tolerances: Sequence[str]) -> list[str]:
    return [
        "; ".join(crossing_text(of["crossings"][ics][number][tolerance]) for tolerance in tolerances)
        for ics in FORCE_ICS
    ]


def readme_table(values: Mapping[str, Any]) -> str:
    """Return the table of README's first screen: pair, angle, errors of A, B-hat and, fitted, B-hat-prime."""
    lines = [
        "| error of | Δδ | A, half-space | B̂ | B̂′, with a fit | ± |",
        "|---|---|---|---|---|---|",
    ]
    rows = [
        ("s1002-on-60e1-worn", "loads", 90e3),
        ("arcs-1.02-60", "angles", 80.0),
        ("tall", "loads", 58e3),
        ("tall", "loads", 310e3),
    ]
    for name, key, place in rows:
        at = nearest(values, name, key, place)
        of = [at["errors"][ics]["p_max"] for ics in ("A", "Bhat")]
        lines.append(_readme_row(f"p_max, {at['title']}, {kilonewton(at['load'])}", at["angle"], of, None))
    half, free = "at half the friction limit", "at free rolling"
    for pair, number, where in ((DRAWN, "half", half), (DRAWN, "free", free), (LOOSEST, "half", half)):
        at = nearest(values, f"{pair} 0.4", "angles", 180.0)
        of = [at["errors"][ics][number] for ics in ("A", "Bhat", "Bhat_prime")]
        text = f"F_x, {values['rolling'][pair]['short']}, {where}"
        lines.append(_readme_row(text, at["angle"], of[:2], of[2]))
    return "\n".join(lines)


def _readme_row(
    text: str, angle: float, of: Sequence[Mapping[str, float]], fitted: Mapping[str, float] | None
) -> str:
    known = max(one["estimate"] for one in (*of, *([fitted] if fitted else [])))
    cells = [f"{signed(one['error'])} %" for one in of] + [f"{signed(fitted['error'])} %" if fitted else ""]
    return f"| {text} | {angle:.0f}° | {' | '.join(cells)} | ± {max(100 * known, 0.1):.1f} % |"


def load_of(found: Mapping[str, Any], pair: Mapping[str, Any]) -> str:
    """Return the load of a crossing and, read between the loads that were solved, p_max with C there."""
    if found["at"] is None:
        return "–"
    load = found["at"]["load"]
    pressure = np.exp(np.interp(np.log(load), np.log(pair["loads"]), np.log(pair["p_max"])))
    return f"{kilonewton(load)}, {float(f'{pressure:.2g}'):.0f} MPa"


def kilonewton(load: float) -> str:
    return f"{load / 1e3:.3g} kN" if load < 1e6 else f"{load / 1e3:.0f} kN"
