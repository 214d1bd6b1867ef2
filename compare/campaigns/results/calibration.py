"""Fits of B-hat-prime to C of a scene."""

import numpy as np
import xarray as xr

from compare.campaigns.results.kind import SHARE, ResultKind
from femic.reference.run_options import RunOptions
from femic.results.calibration import calibrate, extended, require_calibration, unit_of
from femic.results.ics import jobs
from femic.scenes.scene import Scene

NAMES = frozenset(
    {"fit_value", "fit_rms", "fit_worst", "fit_c", "Bhat_worst"}
    | {"fitted_body", "parameter", "fitted_component", "fit_point"}
)


def calibration(scene: Scene, options: RunOptions) -> xr.Dataset:
    """Return parameters of B-hat-prime, and its deviations from C beside those of B-hat, by fitted body."""
    calibrated = calibrate(scene, options)
    fits, targets = list(calibrated.fits.values()), list(calibrated.targets.values())
    bhat_worst = [
        np.max(np.abs(target.approximate("Bhat") - target.ics) / target.scales, axis=-1) for target in targets
    ]
    parameters, components = ("fitted_body", "parameter"), ("fitted_body", "fitted_component")
    share = SHARE | {"long_name": "deviation from C, share of max |C| of the points"}
    about_c = {"units": "1", "long_name": "C at the points of the calibration, without dimension"}
    return xr.Dataset(
        {
            "fit_value": (
                parameters,
                [[parameter.value for parameter in fit.parameters] for fit in fits],
                {"long_name": "fitted parameters; r_inf in mm, G in MPa"},
            ),
            "fit_rms": (components, np.stack([fit.rms for fit in fits]), share),
            "fit_worst": (components, np.stack([fit.worst for fit in fits]), share),
            "fit_c": (
                (*components, "fit_point"),
                np.stack([unit_of(scene) * target.ics for target in targets]),
                about_c,
            ),
            "Bhat_worst": (components, np.array(bhat_worst), share),
        },
        coords={
            "fitted_body": list(calibrated.fits),
            "parameter": [parameter.name for parameter in fits[0].parameters],
            "fitted_component": list(scene.calibration.components),
        },
    )


CALIBRATION = ResultKind(calibration, lambda scene: [jobs(extended(scene))], require_calibration, NAMES)
