"""A figure of the numbers of a statement beside their thresholds."""

import matplotlib as mpl
import numpy as np
from matplotlib.figure import Figure

from compare.report.static import RC
from femic.validation.statements.verdicts import Finding

MET, UNMET = "tab:green", "tab:red"


def numbers(finding: Finding) -> Figure:
    """Draw every number beside its threshold, with a separate scale for each criterion."""
    criteria = finding.statement.criteria
    values = finding.values
    heights = [len(values[criterion.name]) + 1.6 for criterion in criteria]
    with mpl.rc_context(RC):
        figure = Figure(figsize=(9, 0.24 * sum(heights) + 0.4), layout="constrained")
        grid = figure.subplots(len(criteria), 1, squeeze=False, height_ratios=heights)[:, 0]
        for axes, criterion in zip(grid, criteria, strict=True):
            case_values = values[criterion.name]
            positions = np.arange(len(case_values))
            colours = [MET if criterion.met(value) else UNMET for value in case_values.values()]
            axes.barh(positions, list(case_values.values()), color=colours, height=0.6)
            axes.axvline(criterion.threshold, color="black", linewidth=1.2, linestyle="--")
            axes.set_yticks(positions, list(case_values), fontsize=7)
            title = f"{criterion.description}: {criterion.relation} {criterion.threshold:.3g}"
            axes.set_title(title, fontsize=8, loc="left")
            axes.tick_params(axis="x", labelsize=7)
            axes.set_ylim(len(case_values) - 0.4, -0.6)
            axes.margins(x=0.08)
        return figure
