"""Write the worn profiles of the package by their law, or check that the files are by it (--check)."""

import argparse
import sys
from pathlib import Path

import numpy as np

from geometries.profiles.files import read_profile, write_profile
from geometries.profiles.standards import FOLDER, WORN
from geometries.track.wear import worn_pair

ROUNDING = 1e-6  # mm: between computers


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--check", action="store_true", help="compare with the files, write nothing")
    check = parser.parse_args().check
    profiles = {profile.kind: profile for profile in worn_pair()}
    differing = []
    for entry in WORN.values():
        if not check:
            write_profile(profiles[entry.kind], entry.path)
        elif not same(entry.path, profiles[entry.kind].points):
            differing.append(entry.file)
    if differing:
        sys.stderr.write(f"{FOLDER}: {', '.join(differing)}: not by the law; run tools/worn_profiles.py\n")
    return 1 if differing else 0


def same(path: Path, points: np.ndarray) -> bool:
    stored = read_profile(path).points
    return stored.shape == points.shape and bool(np.allclose(stored, points, rtol=0, atol=ROUNDING))


if __name__ == "__main__":
    sys.exit(main())
