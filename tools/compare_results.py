"""Compare every array of every dataset in two folders of results: equal to rounding, or not.

    python tools/compare_results.py BEFORE AFTER [--tolerance 1e-9] [--rename OLD=NEW ...]

Datasets are found by their path within the folders; `--rename` names files that are called otherwise in
AFTER. A difference is a share of the largest amount in its array. Seconds, memory and checksums are left out.
Ends with 1 if an array differs by more than the tolerance, has another shape, or is missing.
"""

import argparse
import sys
from collections.abc import Iterator, Mapping
from pathlib import Path

import numpy as np
import xarray as xr

LEFT_OUT = ("seconds", "memory", "checksum", "digest")  # ends of names of arrays that no two runs share
TOLERANCE = 1e-9  # of rounding that iterations have amplified


def main() -> int:
    """Print a line per dataset and per array that differs, and return the exit code."""
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("before", type=Path)
    parser.add_argument("after", type=Path)
    parser.add_argument("--tolerance", type=float, default=TOLERANCE)
    parser.add_argument("--rename", action="append", default=[], metavar="OLD=NEW")
    options = parser.parse_args()
    renamed = dict(pair.split("=") for pair in options.rename)
    failed = False
    for before in datasets_in(options.before):
        path = before.relative_to(options.before)
        after = options.after / path.with_name(renamed.get(path.name, path.name))
        rows = {"": np.inf} if not after.exists() else differences(opened(before), opened(after))
        failed |= report(path, rows, options.tolerance)
    return int(failed)


def datasets_in(folder: Path) -> Iterator[Path]:
    """Yield the datasets of results in a folder, without stored models."""
    for path in sorted(folder.rglob("*.nc")):
        if "store" not in path.parts:
            yield path


def opened(path: Path) -> Mapping[str, np.ndarray]:
    """Return the arrays of a dataset by name."""
    with xr.open_dataset(path, engine="h5netcdf") as dataset:
        return {
            str(name): variable.values
            for name, variable in dataset.load().variables.items()
            if not str(name).endswith(LEFT_OUT)
        }


def differences(before: Mapping[str, np.ndarray], after: Mapping[str, np.ndarray]) -> dict[str, float]:
    """Return the difference of each array, infinite where one of them is missing."""
    return {
        name: difference(before[name], after[name]) if name in before and name in after else np.inf
        for name in sorted({*before, *after})
    }


def difference(before: np.ndarray, after: np.ndarray) -> float:
    """Return the largest difference over the largest amount; infinite for other shapes, texts or gaps."""
    if before.shape != after.shape:
        return np.inf
    if before.dtype.kind not in "fc":
        return 0.0 if np.array_equal(before, after) else np.inf
    finite = np.isfinite(before)
    if not np.array_equal(finite, np.isfinite(after)):
        return np.inf
    largest = np.max(np.abs(before[finite]), initial=0.0)
    return float(np.max(np.abs(before[finite] - after[finite]), initial=0.0) / (largest or 1.0))


def report(path: Path, rows: Mapping[str, float], tolerance: float) -> bool:
    """Print what differs in a dataset; return whether anything does by more than the tolerance."""
    worst = max(rows.values(), default=0.0)
    sys.stdout.write(f"{path}: {len(rows)} arrays, largest difference {worst:.1e}\n")
    for name, value in rows.items():
        if value > tolerance:
            sys.stdout.write(f"    {name}: {value:.1e}\n" if name else "    is missing\n")
    return worst > tolerance


if __name__ == "__main__":
    sys.exit(main())
