"""A profile as it was understood, from a file, smoothed, or a standard: its dataset, and it as points."""

from collections.abc import Callable
from functools import partial
from pathlib import Path

import numpy as np
import xarray as xr

from geometries.profiles.noise import ProfileFigure, noise, profile_figure
from geometries.profiles.preparation import Prepared, equal_steps, sampled
from geometries.profiles.profile import Profile
from geometries.profiles.standards import Worn, named, standard_profile

SPACING = 0.1  # mm, of curves in figures and files
UM = 1e3  # per mm
MakePoints = Callable[[], Profile]
About = dict[str, str | int]  # attributes of the dataset


def file_profile(prepared: Prepared, path: Path) -> tuple[xr.Dataset, MakePoints]:
    """Return a profile of a file by the curve that was made of its points: see `to_dataset`."""
    return _describe(prepared, path.name, str(path.resolve()))


def package_profile(name: str) -> tuple[xr.Dataset, MakePoints]:
    """Return a profile of the package, standard or worn, by its name; raise WrongInput.

    The points of a standard are the ends of its pieces.
    """
    entry = named(name)
    if isinstance(entry, Worn):
        return _describe(entry.outline, f"{name}, {entry.source}", name)
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
    about: About = {
        "kind": entry.kind,
        "source": entry.title,
        "file": name,
        "exact": 1,
        "smoothed": 0,
        "doubt": "",
    }
    return to_dataset(figure, about), partial(standard_profile, name, SPACING)


def _describe(prepared: Prepared, source: str, file: str) -> tuple[xr.Dataset, MakePoints]:
    figure, is_smoothed = profile_figure(prepared, SPACING), prepared.smoothing.length > 0
    about: About = {"kind": prepared.kind, "source": source, "file": file}
    about |= {"exact": 0, "smoothed": int(is_smoothed), "doubt": noise(figure)}
    return to_dataset(figure, about), partial(_make_points, prepared)


def _make_points(prepared: Prepared) -> Profile:
    """Return the given points, or as many of a smoothed curve."""
    if prepared.smoothing.length > 0:
        return sampled(prepared, prepared.length / (len(prepared.places) - 1))
    return Profile(prepared.kind, prepared.points, prepared.name, prepared.notes)


def to_dataset(figure: ProfileFigure, about: About) -> xr.Dataset:
    """Return the curve over its arc length s, and the points, as labelled arrays.

    Attributes: `file` is the absolute path of its file, or its name in the package; `exact` curves, of
    standards, are no fit to points; `doubt` says what looks like noise.
    """
    mm = {"units": "mm"}
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
            **about,
            "curvature_noise": figure.curvature_noise,
            "notes": "\n".join(figure.notes),
        },
    )
