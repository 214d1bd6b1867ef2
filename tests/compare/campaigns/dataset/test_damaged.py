"""Damaged datasets are written anew with the results of the store, and a message says so."""

import shutil
from itertools import cycle

import pytest
import xarray as xr

from compare.campaigns.dataset import open_sweep
from compare.campaigns.run import Options
from tests.compare.campaigns.campaigns import LONGER, assert_sums

PARTS = ("sum", "powers", "failure", "seconds", "digest", "E", "nu", "power")


@pytest.fixture
def large(light_scenes, large_there, sweep, tmp_path):  # noqa: ARG001
    """A large dataset of 15 scenes, its path, and a function that continues it."""
    first = open_sweep(tmp_path).load()

    def run_again():
        """The messages, and the dataset; nothing is computed again."""
        messages = []
        done, dataset = sweep(options=Options(on_message=messages.append))
        assert done.reused == 15
        return messages, dataset.load()

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
        chunk = sorted(file for file in (path / part / "c").rglob("*") if file.is_file())[-1]
        damage(chunk)
        messages, again = run_again()
        xr.testing.assert_identical(again, first)
        (message,) = messages
        assert message.startswith(f"{path}: damaged (")
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
        (message,), again = run_again()
        assert f"damaged (no {part})" in message
        xr.testing.assert_identical(again, first)


def test_damage_where_scenes_are_appended(large, sweep):
    """The chunk that cannot be read has room for them."""
    _, path, _ = large
    truncated(path / "sum" / "c" / "2" / "0")
    messages = []
    done, dataset = sweep(LONGER, Options(on_message=messages.append))
    assert f"{path}: damaged (sum/c/2/0: " in messages[0]
    assert done.reused == 15
    assert_sums(dataset)
