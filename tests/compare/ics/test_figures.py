"""Charts and pictures of the report of `femic run`."""

from matplotlib.figure import Figure

from compare.pages.ics_figures import COST, FIGURES
from compare.report import views
from compare.report.charts import Panel, chart_of
from compare.report.parts import Picture
from femic.cli.main import DONE, exit_code


def empty_figure(output):
    yield Picture(f"dummy_of_{output.results.scene.name}", Figure())


def empty_chart(output):
    yield chart_of(f"chart_of_{output.results.scene.name}", [Panel("", "", "", [])])


def test_new_figure_is_one_registration(write_scene, tmp_path, monkeypatch):
    """The report of the command shows it in its section, and its file lies beside those of the others."""
    monkeypatch.setattr(views, "can_render", lambda: False)
    monkeypatch.setitem(FIGURES, COST, (*FIGURES[COST], empty_figure, empty_chart))
    path, out = write_scene('bodies = ["lower"]\ncomponents = ["nn"]'), tmp_path / "out"
    command = ["run", str(path), "--out", str(out), "--store", str(tmp_path / "store"), "--workers", "1"]
    assert exit_code(command) == DONE
    assert (out / "figures" / "dummy_of_mine.png").is_file()
    assert (out / "figures" / "chart_of_mine.svg").is_file()
    html = (out / "report.html").read_text(encoding="utf-8")
    _, after_heading = html.split(f">{COST}</summary>")
    section = after_heading.split("</details>")[0]
    assert 'alt="dummy_of_mine" src="data:image/png' in section
    assert 'id="chart-chart_of_mine"' in section
    assert html.count('alt="dummy_of_mine"') == html.count('id="chart-chart_of_mine"') == 1
