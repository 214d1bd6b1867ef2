"""The Python blocks of docs/python.md and README.md run as they stand; computed pages are up to date."""

import re
import runpy
import shutil
from pathlib import Path

import numpy as np
import pytest

ROOT = Path(__file__).parent.parent
BLOCK = re.compile(r"^```python\n(.*?)^```$", flags=re.DOTALL | re.MULTILINE)


def run_blocks(document):
    """Run the Python blocks of a document one after the other; returns how many, and their names."""
    text, namespace = (ROOT / document).read_text(encoding="utf-8"), {}
    blocks = list(BLOCK.finditer(text))
    for block in blocks:
        above = "\n" * text.count("\n", 0, block.start(1))  # line numbers of the document
        exec(compile(above + block[1], ROOT / document, "exec"), namespace)
    return len(blocks), namespace


def test_pages_with_computed_numbers_are_not_written_by_hand():
    pages = runpy.run_path(str(ROOT / "tools/write_docs.py"))["pages"]()
    assert set(pages) == {"which-ics.md", "validation.md", "extremes.md"}
    for name, text in pages.items():
        assert (ROOT / "docs" / name).read_text(encoding="utf-8") == text, f"{name}: run make docs"


@pytest.fixture(scope="module")
def quick_start(tmp_path_factory):
    """Folder, number of blocks and names of docs/python.md, which runs once."""
    folder = tmp_path_factory.mktemp("docs")
    with pytest.MonkeyPatch.context() as patch:
        patch.chdir(folder)
        return folder, *run_blocks("docs/python.md")


def test_the_quick_start_runs(quick_start):
    _, blocks, names = quick_start
    assert blocks == 7
    assert np.all(names["worst"].sel(variant="C", body=["lower", "upper"], j="n") <= 0.1)


def test_the_ways_of_the_quick_start_agree(quick_start):
    """B and C with a scene and without."""
    _, _, names = quick_start
    alone = {"s": names["s"], "B": names["b_sn"], "C": names["c_sn"]}
    scene = names["ics"].sel(body="lower", i="s", j="n")
    for variant, tolerance in (("B", 1e-12), ("C", 0.1)):
        from_scene = np.interp(alone["s"], scene.s, scene.ic.sel(variant=variant))
        np.testing.assert_allclose(alone[variant], from_scene, rtol=0, atol=tolerance * np.ptp(from_scene))


def test_the_readme_reads_results(quick_start, tmp_path, monkeypatch):
    folder, *_ = quick_start
    (tmp_path / "out/geometry1").mkdir(parents=True)
    shutil.copy(folder / "out/coarse.nc", tmp_path / "out/geometry1/ics.nc")
    monkeypatch.chdir(tmp_path)
    blocks, _ = run_blocks("README.md")
    assert blocks == 1
