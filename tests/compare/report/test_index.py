"""The list of the pages in a folder of results."""

import os

from compare.report.parts import Page, write_index, write_page


def test_all_pages_are_listed_the_newest_first(tmp_path):
    for age, (name, title) in enumerate({"b": "Contact of <b>", "a": "ICs of a"}.items()):
        path = write_page(Page(title, "", []), tmp_path / name / "report.html")
        os.utime(path, (1e9 - age, 1e9 - age))
    text = write_index(tmp_path).read_text(encoding="utf-8")
    assert text.index('href="b/report.html"') < text.index('href="a/report.html"')
    assert "Contact of &lt;b&gt;" in text
    assert not (tmp_path / "figures").exists()


def test_a_folder_without_pages_has_no_list(tmp_path):
    (tmp_path / "a").mkdir()
    assert write_index(tmp_path) is None
    assert not list(tmp_path.glob("*.html"))


def test_unfinished_and_vanished_pages_are_left_out(tmp_path):
    page = write_page(Page("Contact", "", []), tmp_path / "a" / "contact.html")
    page.with_name(".unfinished.1.report.html").write_text("<title>Half</title>", encoding="utf-8")
    (tmp_path / "a" / "gone.html").symlink_to(tmp_path / "nowhere.html")
    text = write_index(tmp_path).read_text(encoding="utf-8")
    assert 'href="a/contact.html"' in text
    assert "Half" not in text
    assert "gone.html" not in text
