"""Benchmark of the IC matrix: seconds, memory, files (docs/evidence/performance.md).

    python benchmarks/matrix.py [n_s ...] [--record]

Geometry 2, both bodies and their sum, nine components, tolerance 0.001, 2 threads, a process each:
seconds of all models and of making and checking the matrices, largest model, peak memory of all processes,
sizes of the file and of the store; then the same scene again; growth exponents with n_s; what 64 single loads
would take.
"""

import json
import subprocess
import sys
import tempfile
from pathlib import Path
from time import perf_counter

import numpy as np
import xarray as xr
from tables import Record, arguments, keep, line_of, print_table

from femic.cache.store import Store
from femic.reference.run_options import RunOptions
from femic.results.ics import compute
from femic.results.matrices import compute_matrix
from femic.scenes.load import load_scene

TOLERANCE = 1e-3
LAGS = {32: 64, 64: 128, 128: 256}
COLUMNS = (
    "n_s",
    "n_x",
    "time [s]",
    "models alone [s]",
    "again, with stored models [s]",
    "unknowns",
    "memory [MB]",
    "file [MB]",
    "store [MB]",
    "estimated error",
)
RECORD = Record(
    "matrix.matrices",
    "IC matrices",
    "Geometry 2, both bodies and their sum, nine components, tolerance 0.001, n_s strips and n_x lags. "
    "Memory is the sum of the peaks of all processes.",
    "python benchmarks/matrix.py",
)


def print_row(n_s: int, n_x: int) -> None:
    """Compute a matrix, twice with the same store, and print the row."""
    engine = {"check": False, "tolerance": TOLERANCE}
    scene = load_scene("geometry2", {"grid": {"n_s": n_s, "n_x": n_x}, "engine": engine})
    with tempfile.TemporaryDirectory() as folder:
        store, path = Store(Path(folder) / "store"), Path(folder) / "matrix.nc"
        references = compute_matrix(scene, path, RunOptions(2, store))
        with xr.open_dataset(path, engine="h5netcdf") as file:
            attributes = file.attrs
        costs = [cost for matrix in references.values() for cost in matrix.models.values()]
        models = sum(sum(cost.seconds.values()) for cost in costs)
        start = perf_counter()
        compute_matrix(scene, path, RunOptions(2, store))
        again = perf_counter() - start
        stored = sum(file.stat().st_size for file in (Path(folder) / "store").rglob("*.nc"))
        cells = (
            n_s,
            n_x,
            f"{attributes['seconds']:.0f}",
            f"{models:.0f}",
            f"{again:.0f}",
            f"{max(cost.unknowns for cost in costs):,}",
            f"{max(attributes['peak_memory'], *(cost.peak_memory for cost in costs)):.0f}",
            f"{path.stat().st_size / 1e6:.0f}",
            f"{stored / 1e6:.0f}",
            f"{max(shares['total'] for shares in json.loads(attributes['estimated_error']).values()):.2%}",
        )
        print(line_of(cells), flush=True)


def single_loads(n: int) -> None:
    """Print the seconds of n single loads, extrapolated from one."""
    engine = {"check": False, "tolerance": TOLERANCE}
    start = perf_counter()
    compute(load_scene("geometry2", {"engine": engine}), RunOptions(2))
    seconds = perf_counter() - start
    print(f"\none load at s = 0: {seconds:.0f} s; {n} of them, extrapolated: {n * seconds:.0f} s", flush=True)


def main() -> None:
    given = arguments()
    if len(given) == 3 and given[0] == "--one":
        print_row(int(given[1]), int(given[2]))
        return
    chosen = [int(value) for value in given] or list(LAGS)
    print_table(COLUMNS, [])
    rows, cells = [], []
    for n_s in chosen:
        command = [sys.executable, __file__, "--one", str(n_s), str(LAGS.get(n_s, 2 * n_s))]
        text = subprocess.run(command, check=True, capture_output=True, text=True).stdout
        print(text, end="", flush=True)
        cells.append([cell.strip() for cell in text.strip().strip("|").split("|")])
        rows.append(
            [float(cell.replace(",", "").rstrip("% ")) for cell in text.strip().strip("|").split("|")]
        )
    keep(RECORD, COLUMNS, cells)
    if len(rows) > 1:
        table = np.array(rows)
        for column in (2, 3, 5, 6, 7, 8):
            slope = np.polyfit(np.log(table[:, 0]), np.log(table[:, column]), 1)[0]
            print(f"{COLUMNS[column]} grows like n_s^{slope:.1f}", flush=True)
    single_loads(64)


if __name__ == "__main__":
    main()
