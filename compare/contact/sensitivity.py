"""Where A and B-hat differ under given pressures: maps of scenes' pressures on each other's patches."""

from collections.abc import Iterator, Mapping
from dataclasses import dataclass

import matplotlib as mpl
import numpy as np
from matplotlib.figure import Figure
from scipy.interpolate import RegularGridInterpolator

from compare.contact.compute import ContactResults
from compare.report.styles import RC
from femic.contact.pairs.frictionless import SolvedContact
from femic.contact.pairs.quantities import half_length, s_range
from femic.scenes.scene import Scene
from geometries.arrays import Array

SHAPE = "Bhat"  # the ICs whose pressures are mapped


@dataclass(frozen=True, eq=False)
class Sensitivity:
    """(u_n by A - u_n by B-hat) / max u_n by B-hat on the patch of a scene, by the pressures of another."""

    shape: str  # the scene whose pressures are mapped
    scene: str  # the scene onto whose patch they are mapped
    x: Array  # [mm], (n_x,)
    s: Array  # [mm], (n_s,)
    in_patch: Array  # pressures, 0 beside the patch, (n_x, n_s)
    difference: Array  # (n_x, n_s)

    @property
    def inside(self) -> Array:
        """The differences on the patch, (n,)."""
        return np.asarray(self.difference[self.in_patch > 0])

    @property
    def largest(self) -> float:
        """The largest difference on the patch."""
        return float(np.max(np.abs(self.inside)))


def sensitivities(results: Mapping[str, ContactResults]) -> Iterator[Sensitivity]:
    """Yield the maps of all pressures on all patches."""
    shapes = {name: shape_of(of_scene) for name, of_scene in results.items()}
    for shape_name, shape in shapes.items():
        for name, onto in shapes.items():
            p = mapped(shape, onto)
            by_a, by_bhat = (onto.on_grid.operator(ics)(p[..., None])[..., 0] for ics in ("A", SHAPE))
            difference = (by_a - by_bhat) / np.max(by_bhat)
            yield Sensitivity(
                shape_name, name, onto.on_grid.x, onto.on_grid.grid.strips, onto.normal.p, difference
            )


def is_mapped(scene: Scene) -> bool:
    """Whether the contact of a scene is one without friction that is solved by B-hat, too."""
    return scene.contact.friction is None and SHAPE in scene.contact.ics


def shape_of(results: ContactResults) -> SolvedContact:
    """The contact by B-hat whose pressures are mapped: at `contact.shape_load`, or the largest load."""
    contacts = [contact for (_, ics), contact in results.solved.contacts.items() if ics == SHAPE]
    shape_load = results.scene.contact.shape_load
    if shape_load is None:
        return max(contacts, key=lambda contact: contact.normal.load)
    return min(contacts, key=lambda contact: abs(contact.normal.load - shape_load))


def mapped(shape: SolvedContact, onto: SolvedContact) -> Array:
    """Pressures of one contact on the patch of another, at the same x / a and s / b; shape (n_x, n_s)."""
    on_grid = shape.on_grid
    interpolate = RegularGridInterpolator(
        (on_grid.x / _half_length(shape), _normalised(shape)),
        shape.normal.p,
        bounds_error=False,
        fill_value=0.0,
    )
    x, s = onto.on_grid.x / _half_length(onto), _normalised(onto)
    return np.asarray(interpolate(np.stack(np.meshgrid(x, s, indexing="ij"), axis=-1)))


def _half_length(contact: SolvedContact) -> float:
    return half_length(contact.on_grid, contact.normal)


def _normalised(contact: SolvedContact) -> Array:
    """Arc lengths of the strips from the middle of the patch, over its half-width."""
    low, high = s_range(contact.on_grid, contact.normal)
    return np.asarray((contact.on_grid.grid.strips - (low + high) / 2) / ((high - low) / 2))


def summary(results: Mapping[str, ContactResults]) -> str:
    """How much A and B-hat differ within each patch, at least and at most, and by which pressures most."""
    found = list(sensitivities(results))
    sentences = [
        f"Pressures of {one.shape} on {one.scene}: A is off by {np.min(one.inside):+.1%} ... "
        f"{np.max(one.inside):+.1%} of the largest displacement with B̂."
        for one in found
    ]
    for scene in results:
        worst = max((one for one in found if one.scene == scene), key=lambda one: one.largest)
        sentences.append(f"On the patch of {scene} A is furthest off under the pressures of {worst.shape}.")
    return " ".join(sentences)


def maps(results: Mapping[str, ContactResults]) -> Figure:
    """Draw the maps, a row per shape, a column per scene."""
    drawn = list(sensitivities(results))
    n = round(np.sqrt(len(drawn)))
    largest = max(one.largest for one in drawn)
    with mpl.rc_context(RC | {"axes.grid": False}):
        figure = Figure(figsize=(4.6 * n, 3.4 * n), layout="constrained")
        for axes, one in zip(figure.subplots(n, n, squeeze=False).ravel(), drawn, strict=True):
            shown = np.ma.masked_where(one.in_patch == 0, one.difference)
            shades = axes.pcolormesh(
                one.x, one.s, shown.T, cmap="RdBu_r", vmin=-largest, vmax=largest, rasterized=True
            )
            axes.set(xlabel="x [mm]", ylabel="s [mm]", title=f"pressures of {one.shape} on {one.scene}")
            for limit, place, inside in (
                (axes.set_xlim, one.x, (one.in_patch > 0).any(axis=1)),
                (axes.set_ylim, one.s, (one.in_patch > 0).any(axis=0)),
            ):
                limit(place[inside].min(), place[inside].max())
        figure.colorbar(shades, ax=figure.axes, label="(u_n with A − u_n with B̂) / max u_n with B̂ [-]")
        return figure
