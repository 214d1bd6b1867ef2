"""Datasets that something else has changed: their scenes are computed again, and a message says so."""

import shutil
from itertools import cycle

import numpy as np
import pytest
import xarray as xr
import zarr

from compare.campaigns.integrity import open_sweep, value_checksums
from compare.campaigns.run import Options
from tests.compare.campaigns.campaigns import LONGER, assert_sums

PARTS = ("sum", "powers", "failure", "seconds", "digest", "checksum", "E", "nu", "power")


@pytest.fixture
def large(light_scenes, large_there, sweep, tmp_path):  # noqa: ARG001
    """A large dataset of 27 scenes, its path, and a function that continues it."""
    first = open_sweep(tmp_path).load()

    def run_again():
        """The messages, and the dataset."""
        messages = []
        sweep(options=Options(on_message=messages.append))
        return messages, open_sweep(tmp_path).load()

    return first, tmp_path / "sweep.zarr", run_again


def deleted(path):
    path.unlink()


def emptied(path):
    path.write_bytes(b"")


def truncated(path):
    path.write_bytes(path.read_bytes()[:-5])


def flipped(path):
    content = bytearray(path.read_bytes())
    content[2 * len(content) // 3] ^= 0x10
    path.write_bytes(content)


def a_folder(path):
    path.unlink()
    path.mkdir()


DAMAGES = (deleted, flipped, a_folder, emptied, truncated)
SOME = ("sum", "failure", "digest", "E", "power")  # by default: numbers, texts, what is known of scenes, axes
EACH_ONE = [pytest.param(PARTS, [damage], id=damage.__name__, marks=pytest.mark.slow) for damage in DAMAGES]


@pytest.mark.parametrize(("parts", "damages"), [pytest.param(SOME, DAMAGES, id="in turn"), *EACH_ONE])
def test_damaged_chunk_is_reported_and_restored(large, parts, damages):
    """After each damage the dataset is whole again: each part of it, and each damage."""
    first, path, run_again = large
    for part, damage in zip(parts, cycle(damages)):
        damage(sorted(file for file in (path / part / "c").rglob("*") if file.is_file())[-1])
        messages, again = run_again()
        xr.testing.assert_identical(again, first)
        assert len(messages) == 1
        assert "damaged" in messages[0]
    assert run_again()[0] == []


@pytest.mark.parametrize(("parts", "damages"), [pytest.param(SOME, DAMAGES[:2], id="in turn"), *EACH_ONE[:2]])
def test_damaged_descriptions_are_restored(large, parts, damages):
    """Not all of them say anything that matters."""
    first, path, run_again = large
    for part, damage in zip(("", *parts), cycle(damages)):
        damage(path / part / "zarr.json")
        xr.testing.assert_identical(run_again()[1], first)


@pytest.mark.parametrize(
    "parts",
    [pytest.param(("sum", "digest", "E"), id="some"), pytest.param(PARTS, id="all", marks=pytest.mark.slow)],
)
def test_missing_variable_is_reported_and_restored(large, parts):
    first, path, run_again = large
    for part in parts:
        shutil.rmtree(path / part)
        messages, again = run_again()
        xr.testing.assert_identical(again, first)
        assert "all its scenes are computed again" in messages[0]


def test_only_changed_scenes_are_computed_again(large, light_scenes):
    """By the smallest amount, to something that is no number, exchanged, without their message."""
    _, path, run_again = large
    group = zarr.open_group(path, mode="a")
    group["sum"][0, 0] = np.nextafter(group["sum"][0, 0], 9)
    group["sum"][1, 1] = -group["sum"][1, 1]
    group["powers"][2, 2, 1] = np.nan
    group["powers"][4:6, 0] = group["powers"][4:6, 0][::-1]
    group["sum"][6, 1] = 1.0  # of a scene that has failed
    group["failure"][6, 2] = ""
    group["seconds"][8, 2] = 1e3
    shutil.rmtree(path.parent / "store")
    del light_scenes[:]
    messages, again = run_again()
    assert messages == [f"{path}: 8 scenes are damaged or half written: they are computed again"]
    assert sorted(light_scenes) == sorted(
        [(1, 0.1), (2, 0.2), (3, 0.3), (5, 0.1), (6, 0.1), (7, 0.2), (7, 0.3), (9, 0.3)]
    )
    assert_sums(again)


def test_exchanged_scenes_are_computed_again(large):
    first, path, run_again = large
    chunks = [path / "powers" / "c" / str(k) / "0" / "0" for k in (2, 3)]
    contents = [chunk.read_bytes() for chunk in chunks]
    for chunk, content in zip(chunks, reversed(contents), strict=True):
        chunk.write_bytes(content)
    messages, again = run_again()
    assert messages == [f"{path}: 6 scenes are damaged or half written: they are computed again"]
    xr.testing.assert_identical(again, first)


def test_damage_where_scenes_are_appended(large, sweep):
    """The chunk that cannot be read has room for them."""
    _, path, _ = large
    chunk = path / "sum" / "c" / "4" / "0"
    truncated(chunk)
    messages = []
    done, dataset = sweep(LONGER, Options(on_message=messages.append))
    assert messages == [f"{path}: 3 scenes are damaged or half written: they are computed again"]
    assert done.reused == 27
    assert_sums(dataset)


def test_checksums_of_different_values_differ():
    values = np.array([[1.0, 2.0], [2.0, 1.0], [1.0, -2.0], [np.nan, 2.0], [2.0, np.nan], [0.0, -0.0]])
    numbers = value_checksums("y", values, 1)
    assert len({*numbers.tolist()}) == 6
    assert not {*numbers.tolist()} & {*value_checksums("z", values, 1).tolist()}
    assert [int(value_checksums("y", row)) for row in values] == numbers.tolist()


def test_checksum_of_nan_is_zero_whatever_its_bits():
    assert not value_checksums("y", np.full((3, 2, 4), np.nan), 2).any()
    negative = np.array([1.0, np.copysign(np.nan, -1)])
    assert value_checksums("y", negative) == value_checksums("y", np.array([1.0, np.nan]))
