"""Read a table of creep forces that femic wrote (table.txt), and interpolate in it. Needs NumPy alone.

    table = read("table.txt")
    contact = table.contact(shift=1.5, load=80e3)
    forces = table.forces(shift=1.5, load=80e3, friction=0.3, longitudinal=-1e-3)

Units are mm, N, MPa, rad. x points along the track, z up from the rail into the wheel. The approach of the
bodies is that under the `load` without friction; it stays when friction acts. Creepages are those of the
wheel: `longitudinal` is omega R / V - 1, `lateral` the lateral velocity over V, `spin` [1/mm] the angular
velocity about z over V. What the contact angle adds to slip and spin is in the table.

All is interpolated by cubic polynomials between nodes, with slopes of parabolas through three of them, so
that slopes are continuous; over the logarithm of the load. Creepages are polar, over those that make a
contact slide (docs/theory/tables.md).
"""

import math
from collections.abc import Iterable, Iterator, Mapping
from pathlib import Path

import numpy as np
from numpy.typing import ArrayLike, NDArray

Numbers = NDArray[np.float64]
Indices = NDArray[np.intp]

AXES = ("shift", "load", "friction", "spin", "angle", "creepage")
RANGE_SLACK = 1e-9  # relative, of the ends of an axis


class Table:
    """Nodes of the axes; quantities of contacts over (shift, load); and of forces over all axes."""

    def __init__(
        self,
        axes: Mapping[str, ArrayLike],
        contacts: Mapping[str, ArrayLike],
        logarithmic: Iterable[str],
        forces: Mapping[str, ArrayLike],
    ) -> None:
        """Take nodes by axis, quantities by name, the names whose logarithms are interpolated, and shares."""
        self.axes = {name: np.asarray(axes[name], float) for name in AXES}
        self.names, self.logarithmic = tuple(contacts), frozenset(logarithmic)
        self.quantities = np.stack(
            [np.log(values) if name in self.logarithmic else values for name, values in contacts.items()]
        )
        self.force_names, self.values = tuple(forces), np.stack(list(forces.values()))

    def contact(self, shift: float, load: float) -> dict[str, float]:
        """Return the contact without friction: forces, angle, sizes and scales by name."""
        (i, u), (j, v) = self._at("shift", shift), self._at("load", load)
        values = u @ self.quantities[:, i[:, None], j] @ v
        return {
            name: float(np.exp(value) if name in self.logarithmic else value)
            for name, value in zip(self.names, values, strict=True)
        }

    def forces(  # noqa: PLR0913, PLR0917 (as in C)
        self,
        shift: float,
        load: float,
        friction: float,
        longitudinal: float,
        lateral: float = 0.0,
        spin: float = 0.0,
    ) -> dict[str, float]:
        """Return forces [N] on the wheel along x, y, z; M_n [N mm] about the normal; p_max; work [N].

        M_n is about the centre of pressures (y, z of `contact`), work is per unit of rolled distance. Raises
        ValueError outside the table.
        """
        contact = self.contact(shift, load)
        sine, cosine = math.sin(contact["contact_angle"]), math.cos(contact["contact_angle"])
        saturation = friction * contact["creepage_scale"]
        along = (longitudinal - contact["free_creepage"] + spin * contact["y"]) / saturation
        across = lateral * cosine / saturation
        creepage = math.hypot(along, across)
        value = self.shares(
            shift,
            load,
            friction,
            spin * contact["half_size"] / saturation,
            math.atan2(across, along),
            creepage / (1 + creepage),
        )
        unit = friction * contact["normal_force"]
        tangential, normal = unit * value["f_y"], contact["normal_force"] * value["f_n"]
        return {
            "F_x": unit * value["f_x"],
            "F_y": tangential * cosine - normal * sine,
            "F_z": tangential * sine + normal * cosine,
            "M_n": unit * contact["half_size"] * value["m_n"],
            "p_max": contact["p_max"] * value["p"],
            "work": unit * saturation * (1 + creepage) * value["w"],
        }

    def shares(self, *at: float) -> dict[str, float]:
        """Return the interpolated shares at values of all axes, by name."""
        polar = self._polar(*at[4:])
        block = self.values[..., polar[0], polar[1]] @ polar[2]
        for name, value in zip(("spin", "friction", "load", "shift"), at[3::-1], strict=True):
            indices, weights = self._at(name, value)
            block = block[..., indices] @ weights
        return dict(zip(self.force_names, block.tolist(), strict=True))

    def _at(self, name: str, value: float) -> tuple[Indices, Numbers]:
        """Return indices and weights of the nodes of an axis about a value."""
        nodes = self.axes[name]
        slack = RANGE_SLACK * max(abs(nodes[0]), abs(nodes[-1]))
        if not nodes[0] - slack <= value <= nodes[-1] + slack:
            raise ValueError(f"{name} = {value:g}: the table has {nodes[0]:g} to {nodes[-1]:g}")
        value = min(max(value, nodes[0]), nodes[-1])
        return stencil(np.log(nodes), math.log(value)) if name == "load" else stencil(nodes, value)

    def _polar(self, angle: float, creepage: float) -> tuple[Indices, Indices, Numbers]:
        """Return indices of angles and creepages, and weights: no creepage lies between opposite angles."""
        n, radii = len(self.axes["angle"]), self.axes["creepage"]
        turns = angle / (2 * math.pi) * n  # of a circle, in steps of the angles
        first = math.floor(turns)
        around, along_circle = stencil(np.arange(first - 1.0, first + 3.0), turns)
        outward, along_ray = stencil(np.concatenate([[-radii[1]], radii]), min(max(creepage, 0.0), 1.0))
        opposite = outward == 0
        angles = around[:, None] + first - 1 + np.where(opposite, n // 2, 0)
        places = np.broadcast_to(np.where(opposite, 1, outward - 1), angles.shape)
        return (angles % n).ravel(), places.ravel(), np.outer(along_circle, along_ray).ravel()


def stencil(nodes: Numbers, value: float) -> tuple[Indices, Numbers]:
    """Return indices and weights of up to four nodes, for the value of a smooth function at `value`."""
    last = len(nodes) - 1
    if last == 0:
        return np.array([0]), np.array([1.0])
    k = min(max(int(np.searchsorted(nodes, value, "right")) - 1, 0), last - 1)
    width = nodes[k + 1] - nodes[k]
    t = (value - nodes[k]) / width
    weights = np.zeros(last + 1)
    weights[k : k + 2] += (1 + 2 * t) * (1 - t) ** 2, t * t * (3 - 2 * t)
    for node, share in ((k, width * t * (1 - t) ** 2), (k + 1, -width * t * t * (1 - t))):
        three = min(max(node - 1, 0), max(last - 2, 0)) + np.arange(min(last, 2) + 1)
        weights[three] += share * slope(nodes[three], nodes[node])
    used = np.arange(max(k - 1, 0), min(k + 2, last) + 1)
    return used, weights[used]


def slope(nodes: Numbers, at: float) -> Numbers:
    """Return the weights of two or three nodes in the slope of the polynomial through them."""
    if len(nodes) == 2:
        return np.array([-1.0, 1.0]) / (nodes[1] - nodes[0])
    p, q, r = nodes
    return np.array(
        [
            (2 * at - q - r) / ((p - q) * (p - r)),
            (2 * at - p - r) / ((q - p) * (q - r)),
            (2 * at - p - q) / ((r - p) * (r - q)),
        ]
    )


def read(path: str | Path) -> Table:
    """Return the table in a text file. Raises ValueError if it is none."""
    lines = Path(path).read_text(encoding="utf-8").splitlines()
    words = iter([word for line in lines for word in line.partition("#")[0].split()])
    try:
        if (next(words), next(words)) != ("femic-creep-table", "1"):
            raise ValueError("another kind of file, or another version")
        axes: dict[str, Numbers] = {}
        for name in AXES:
            if next(words) != name:
                raise ValueError(f"the axis {name} is missing")
            axes[name] = numbers(words, int(next(words)))
        shape = tuple(map(len, axes.values()))
        contacts: dict[str, Numbers] = {}
        logarithmic: list[str] = []
        for _ in range(int(next(words))):
            name, scale = next(words), next(words)
            contacts[name] = numbers(words, shape[0] * shape[1]).reshape(shape[:2])
            logarithmic += [name] if scale == "log" else []
        forces = {
            next(words): numbers(words, math.prod(shape)).reshape(shape) for _ in range(int(next(words)))
        }
        if next(words) != "end":
            raise ValueError("something follows where the end should be")
    except StopIteration:
        raise ValueError(f"{path}: no table of femic: it ends too early") from None
    except ValueError as error:
        raise ValueError(f"{path}: no table of femic: {error}") from None
    return Table(axes, contacts, logarithmic, forces)


def numbers(words: Iterator[str], count: int) -> Numbers:
    """Return the next numbers of a file."""
    return np.array([float(next(words)) for _ in range(count)])
