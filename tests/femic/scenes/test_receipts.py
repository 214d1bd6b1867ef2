"""Finished results are taken with their receipt only, and while nothing of them has changed."""

from dataclasses import replace

import pytest

from femic.scenes import receipts
from femic.scenes.load import load_scene


@pytest.fixture
def finished(tmp_path):
    folder = tmp_path / "made"
    with receipts.renewed(folder, "run", "key", ["ics.nc", "errors.nc"]):
        for name in ("ics.nc", "errors.nc"):
            (folder / name).write_text(name, encoding="utf-8")
    return folder


def test_results_hold_for_their_key_and_command(finished):
    assert receipts.holds(finished, "run", "key")
    assert not receipts.holds(finished, "run", "other")
    assert not receipts.holds(finished, "matrix", "key")


def test_interrupted_run_leaves_no_receipt(finished):
    def interrupted():
        with receipts.renewed(finished, "run", "key", ["ics.nc"]) as folder:
            assert folder == finished
            assert not receipts.holds(finished, "run", "key")
            raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        interrupted()
    assert not receipts.holds(finished, "run", "key")


@pytest.mark.parametrize(
    "damage",
    [
        lambda path, _: path.write_text("ics.nC", encoding="utf-8"),
        lambda path, _: path.unlink(),
        lambda path, other: path.write_bytes(other.read_bytes()),
        lambda path, _: (path.unlink(), path.mkdir()),
    ],
    ids=["changed", "missing", "exchanged", "a folder"],
)
def test_changed_results_do_not_hold(finished, damage):
    damage(finished / "ics.nc", finished / "errors.nc")
    assert receipts.changed(finished, "run") == ["ics.nc"]
    assert not receipts.holds(finished, "run", "key")


@pytest.mark.parametrize(
    "text", ["", "{", "[]", '{"key": "key"}', '{"key": "key", "sha256": 3}', "[" * 100000]
)
def test_damaged_receipt_counts_as_missing(finished, text):
    (finished / "run.receipt.json").write_text(text, encoding="utf-8")
    assert not receipts.holds(finished, "run", "key")
    assert receipts.changed(finished, "run") == []


def test_keys_depend_on_code_text_and_bodies(monkeypatch):
    scene = load_scene("geometry2")
    key = receipts.key_of(scene)
    assert key == receipts.key_of(load_scene("geometry2"))
    others = [
        receipts.key_of(scene, "another command"),
        receipts.key_of(scene, 1),
        receipts.key_of(replace(scene, text=f"{scene.text}\n")),
        receipts.key_of(replace(scene, bodies=load_scene("geometry1").bodies)),
    ]
    monkeypatch.setattr(receipts, "results_digest", lambda *_: "0123456789ab")
    assert len({key, *others, receipts.key_of(scene)}) == 6
