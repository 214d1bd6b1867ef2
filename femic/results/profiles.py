"""A profile as it was understood: from a file, smoothed, or a standard."""

from collections.abc import Callable
from dataclasses import dataclass
from functools import partial
from pathlib import Path

import numpy as np
import xarray as xr

from geometries.profiles.noise import ProfileFigure, profile_figure
from geometries.profiles.preparation import Prepared, equal_steps, sampled
from geometries.profiles.profile import Kind, Profile
from geometries.profiles.standards import Worn, named, standard_profile

SPACING = 0.1  # mm, of curves in figures and files
UM = 1e3  # per mm


@dataclass(frozen=True, eq=False)
class Understood:
    """A profile: where it comes from, what a figure shows of it, and a function that makes it as points.

    `file` is the path of its file, absolute; of the package, its name.
    """

    kind: Kind
    source: str
    file: str
    figure: ProfileFigure
    is_exact: bool  # a standard: its curve is no fit to points
    is_smoothed: bool
    as_points: Callable[[], Profile]

    @property
    def length(self) -> float:
        """Length [mm]."""
        return float(self.figure.s[-1])


def of_file(prepared: Prepared, path: Path) -> Understood:
    """Return a profile of a file by the curve that was made of it."""
    return _of_prepared(prepared, path.name, str(path.resolve()))


def of_package(name: str) -> Understood:
    """Return a profile of the package, standard or worn, by its name; raise WrongInput.

    The points of a standard are the ends of its pieces.
    """
    entry = named(name)
    if isinstance(entry, Worn):
        return _of_prepared(entry.outline, f"{name}, {entry.source}", name)
    outline, joints = entry.outline, entry.outline.joints
    s = np.unique(np.concatenate([equal_steps(outline.length, SPACING), joints]))
    figure = ProfileFigure(
        name=name,
        points=outline.position(joints),
        places=joints,
        residual=np.zeros(len(joints)),
        s=s,
        curve=outline.position(s),
        inclination=outline.inclination(s),
        curvature=outline.curvature(s),
        curvature_noise=0.0,
        rounding="",
        notes=(f"{len(outline.pieces)} exact pieces by {entry.source}.",),
    )
    as_points = partial(standard_profile, name, SPACING)
    return Understood(entry.kind, entry.title, name, figure, True, False, as_points)


def _of_prepared(prepared: Prepared, source: str, file: str) -> Understood:
    """Return a profile by the curve that was made of its points."""
    figure, is_smoothed = profile_figure(prepared, SPACING), prepared.smoothing.length > 0
    return Understood(prepared.kind, source, file, figure, False, is_smoothed, partial(_points, prepared))


def _points(prepared: Prepared) -> Profile:
    """Return the given points, or as many of a smoothed curve."""
    if prepared.smoothing.length > 0:
        return sampled(prepared, prepared.length / (len(prepared.places) - 1))
    return Profile(prepared.kind, prepared.points, prepared.name, prepared.notes)


def to_dataset(understood: Understood) -> xr.Dataset:
    """Return the curve over its arc length s, and the points, as labelled arrays."""
    figure, mm = understood.figure, {"units": "mm"}
    return xr.Dataset(
        {
            "y": ("s", figure.curve[0], mm),
            "z": ("s", figure.curve[1], mm),
            "inclination": ("s", figure.inclination, {"units": "rad"}),
            "curvature": ("s", figure.curvature, {"units": "1/mm"}),
            "point_y": ("point", figure.points[0], mm),
            "point_z": ("point", figure.points[1], mm),
            "point_s": ("point", figure.places, mm),
            "residual": ("point", figure.residual, mm),
        },
        {"s": ("s", figure.s, mm)},
        {
            "name": figure.name,
            "kind": understood.kind,
            "source": understood.source,
            "file": understood.file,
            "curvature_noise": figure.curvature_noise,
            "notes": "\n".join(figure.notes),
        },
    )
