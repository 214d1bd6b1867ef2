"""The registry of kinds of results, by their names in campaign files; a new kind is one entry here."""

from collections.abc import Mapping
from types import MappingProxyType
from typing import Any

import xarray as xr

from compare.campaigns.results.advice import ADVICE
from compare.campaigns.results.calibration import CALIBRATION
from compare.campaigns.results.contact import CONTACT
from compare.campaigns.results.kind import ResultKind
from compare.campaigns.results.matrix import MATRIX
from compare.campaigns.results.on_lines import ERRORS, ICS
from compare.campaigns.results.stresses import STRESSES

KINDS: Mapping[str, ResultKind] = MappingProxyType(
    {
        "errors": ERRORS,
        "ics": ICS,
        "contact": CONTACT,
        "stresses": STRESSES,
        "matrix": MATRIX,
        "advice": ADVICE,
        "calibration": CALIBRATION,
    }
)
_EXACT: dict[str, Any] = {"join": "exact", "compat": "equals", "combine_attrs": "override"}


def merge(parts: Mapping[str, xr.Dataset]) -> xr.Dataset:
    """Return results of several kinds as one dataset; common variables are from the first kind."""
    joined = xr.Dataset()
    for part in parts.values():
        new = [name for name in part.data_vars if name not in joined.data_vars]
        joined = joined.merge(part[new], **_EXACT)
    return joined
