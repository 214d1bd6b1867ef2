"""Charts to explore in a notebook: a frame with a page of one chart."""

from importlib import resources

from markupsafe import escape

from compare.report import interactive
from compare.report.charts import Chart

ROOM = 90  # of slider, legend and titles [px]


def in_a_frame(chart: Chart) -> str:
    """Return a chart as HTML that stands for itself, without a network."""
    templates = resources.files("compare.report") / "templates"
    style, script = ((templates / name).read_text(encoding="utf-8") for name in ("style.css", "explore.js"))
    page = (
        f'<!doctype html><html lang="en"><head><meta charset="utf-8"><style>{style}</style></head><body>'
        f'<div class="chart"><script type="application/json">{interactive.as_json(chart)}</script></div>'
        f"<script>{interactive.plotly_js()}</script><script>{script}</script></body></html>"
    )
    rows = max(-(-len(cells) // chart.columns) for cells in chart.steps.values())
    height = ROOM + rows * (interactive.height_of(chart) + 24)
    style = f"width: 100%; height: {height}px; border: 0"
    return f'<iframe title="{escape(chart.name)}" style="{style}" srcdoc="{escape(page)}"></iframe>'
