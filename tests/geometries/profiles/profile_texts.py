"""Sections in closed form, and files of them, written here without the writer under test."""

import numpy as np

MM = {"mm": 1.0, "m": 1000.0, "inch": 25.4}


def rail(n=61):
    """A head without symmetry, undercut on both sides, y to the field side, z up [mm]."""
    t = np.linspace(-1.75, 1.68, n)  # beyond a right angle: the faces lean inwards
    return np.stack([36 * np.sin(t) + 1.5 * np.cos(2 * t), 22 * np.cos(t) + 0.8 * np.sin(t) - 22])


def wheel(n=81):
    """A flange 28 mm below a tread of 1:20, y to the field side, z up [mm]; the axis is above."""
    y = 2 + 133 * np.linspace(0, 1, n)
    return np.stack([y, (y - 70) / 20 - 27 * np.exp(-(((y - 18) / 12) ** 4))])


def columns_text(points, head="", row="{!r} {!r}", end="\n"):
    return head + end.join(row.format(y, z) for y, z in points.T.tolist()) + end


def miniprof_text(points, keys=()):
    head = "".join(f"{key}\n" for key in ("ProgramName=test", "ColumnDef=X,Y", *keys))
    return columns_text(points, head + f"XYPoints={points.shape[1]}\n\n")


def old_miniprof_text(points):
    return columns_text(points, "MINIPROF 101 148\nStock....:\n32.5 37.1 (Sd/Sh)\n\n", "{!r} {!r} 0.000")


def block_text(points, kind="rail", **keys):
    """Points as they are; keys with _ for the dots."""
    lines = [f"{key.replace('_', '.')} = {value}" for key, value in ({"units_len_f": 1000} | keys).items()]
    head = ["! test", "header.begin", f"type = {int(kind == 'wheel')}", "header.end", "spline.begin"]
    rows = columns_text(points, "\n".join([*head, *lines, "point.begin"]) + "\n")
    return rows + "point.end\nspline.end\n"
