"""What looks like noise in a profile: last decimals that bend the curve, radii far below real ones."""

import numpy as np

from geometries.profiles.preparation import ProfileFigure

LEAST_RADIUS = 2.0  # mm: the package has 11 mm and more, edges below railheads 2.6 mm; less looks like noise
USUAL = 0.01  # mm: a tolerance for measured points


def noise(figure: ProfileFigure) -> str:
    """Return what looks like noise in a profile, and a tolerance to take; nothing where nothing does.

    That is what the last decimals of its file do, or a radius far below those of profiles.
    """
    if figure.rounding:
        return figure.rounding
    at = int(np.argmax(np.abs(figure.curvature)))
    if LEAST_RADIUS * abs(figure.curvature[at]) <= 1:
        return ""
    rms = float(np.sqrt(np.mean(figure.residual**2)))
    remedy = f"a tolerance of {USUAL:g} mm" if rms < 0.9 * USUAL else "a larger tolerance"
    return (
        f"The least radius is {radius_text(figure, at)} mm (at s = {figure.s[at]:.1f} mm), below "
        f"{LEAST_RADIUS:g} mm: standard profiles have 12 mm and more, so this looks like noise or a burr. "
        f"Try {remedy}."
    )


def radius_text(figure: ProfileFigure, at: int) -> str:
    """Return the radius of curvature [mm] at a place of a figure."""
    return f"{1 / abs(figure.curvature[at]):.3g}"
