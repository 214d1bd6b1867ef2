"""Kinds of results: functions of a scene that return a dataset of numbers.

The dims of a variable depend on the scene's own keys only, and all variables are numbers: places and loads
are variables, because they may differ between scenes. The check with the other engine (`engine.check`) is
left out.
"""

from collections.abc import Callable, Mapping
from dataclasses import dataclass

import xarray as xr

from femic.reference.job import Job
from femic.reference.matrix.job import MatrixJob
from femic.reference.run_options import RunOptions
from femic.scenes.scene import Scene

Jobs = Mapping[str, Job] | Mapping[str, MatrixJob]
SHARE = {"units": "1"}


@dataclass(frozen=True)
class ResultKind:
    """A kind of results that a campaign can keep of its scenes."""

    compute: Callable[[Scene, RunOptions], xr.Dataset]
    jobs: Callable[[Scene], list[Jobs]]  # C by body, as far as it is known before the computation
    require: Callable[[Scene], object] = lambda _: None  # raises BadScene where the scene has no such results
    names: frozenset[str] = frozenset()  # of all variables and dims
    seconds: Callable[[Scene], float] = lambda _: 1.0  # besides those of C, roughly
