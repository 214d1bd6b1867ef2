"""Names of scenes and campaigns, which name folders; seeds of campaigns."""

import pytest

from compare.campaigns.load import load_campaign
from femic.scenes.errors import BadScene
from femic.scenes.load import load_scene, load_solid_scene

CAMPAIGN = """
scene = "flat"
points = "random"
samples = 3
[sweep.E]
keys = ["lower.E"]
from = 1e5
to = 2e5
"""


@pytest.mark.parametrize("name", ["...toml", "..toml", " .toml", "a\nb.toml"])
def test_names_that_no_folder_can_have_are_refused(name, tmp_path):
    path = tmp_path / name
    for text, load in (
        (load_scene("flat").text, lambda: load_scene(str(path))),
        (load_scene("flat").text, lambda: load_solid_scene(str(path))),
        (CAMPAIGN, lambda: load_campaign(path)),
    ):
        path.write_text(text, encoding="utf-8")
        with pytest.raises(BadScene, match=r"names the folder of results, .*: rename it"):
            load()


@pytest.mark.parametrize("name", [".hidden.toml", "a b.toml", "Räder.toml", "mine"])
def test_other_file_names_become_scene_names(name, tmp_path):
    path = tmp_path / name
    path.write_text(load_scene("flat").text, encoding="utf-8")
    assert load_scene(str(path)).name == name.removesuffix(".toml")


def test_negative_or_non_integer_seeds_are_refused(tmp_path):
    path = tmp_path / "mine.toml"
    for seed, allowed in ((0, True), (7, True), (-3, False), ('"3"', False), ("true", False)):
        path.write_text(f"seed = {seed}\n{CAMPAIGN}", encoding="utf-8")
        if allowed:
            assert load_campaign(path).size == 3
        else:
            with pytest.raises(BadScene, match=r"seed = .*: Input should be "):
                load_campaign(path)
