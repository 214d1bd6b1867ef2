"""What is shown while models are solved, on a terminal and in a file."""

import re
from io import StringIO
from types import SimpleNamespace

import pytest
from rich.console import Console

from femic.cli import progress
from femic.cli.progress import EVERY, ProgressLines, show_progress, step_text, terminal
from femic.reference.engine import Cost, RawICs
from femic.reference.engines import HARMONIC
from femic.reference.refinement import solve_models
from femic.reference.run_options import Level, RunOptions, Solved, Step, Task
from tests.femic.reference.small_model import TASK

LOWER = Task("lower", Level(), None, 1000)
UPPER = Task("upper", Level(cells=-1), None, 1000)
NAMES = {LOWER: "  lower body, cells x 1, domain x 1", UPPER: "  upper body, cells x 1.5, domain x 1"}


def solved(task, *, cached=False):
    cost = Cost(12_345, 1, "direct", (), 0.0, {"mesh": 1.0, "solution": 2.25}, 0.0)
    return Solved(task, RawICs(None, cost), cached)


@pytest.fixture
def heard():
    """Lines with a clock that is set by hand, and what they have written."""
    clock, written = SimpleNamespace(now=100.0), []
    return ProgressLines(written.append, lambda: clock.now), clock, written


def test_model_writes_a_line_at_its_start_and_every_few_seconds(heard):
    lines, clock, written = heard
    lines.on_step(Step(LOWER, "mesh and assembly"))
    assert written == [f"{NAMES[LOWER]}: mesh and assembly"]
    for k in range(1, 120):
        clock.now += 0.1
        lines.on_step(Step(LOWER, "first wavenumbers", k, 44))
    assert len(written) == 1 + int(119 * 0.1 / EVERY)
    assert re.fullmatch(re.escape(NAMES[LOWER]) + r": (49|50|51) wavenumbers, 5 s", written[1])
    more_than_expected = re.escape(NAMES[LOWER]) + r": \d+ wavenumbers, 10 s"
    assert re.fullmatch(more_than_expected, written[2])


def test_silent_models_have_lines_until_they_are_finished(heard):
    """Solids are solved in other processes: only the clock goes on."""
    lines, clock, written = heard
    for task in (LOWER, UPPER):
        lines.on_step(Step(task, "solid engine at work"))
        clock.now += 3.0
    lines.write_if_due()
    assert len(written) == 2  # of both beginnings; the latter was 3 s ago
    clock.now += EVERY
    lines.write_if_due()
    assert written[2:] == [
        f"{NAMES[LOWER]}: solid engine at work, 11 s",
        f"{NAMES[UPPER]}: solid engine at work, 8 s",
    ]
    lines.on_model(solved(LOWER))
    assert written[-1] == f"{NAMES[LOWER]}: 12,345 unknowns, 3.2 s"
    clock.now += EVERY
    lines.write_if_due()
    assert written[5:] == [f"{NAMES[UPPER]}: solid engine at work, 13 s"]
    lines.on_model(solved(UPPER, cached=True))
    assert written[-1].endswith("stored by an earlier run")
    clock.now += 10 * EVERY
    lines.write_if_due()
    assert len(written) == 7


@pytest.mark.parametrize(
    ("stage", "text"),
    [
        (("mesh and assembly",), "mesh and assembly"),
        (("first wavenumbers", 0, 44), "first wavenumbers"),
        (("first wavenumbers", 7, 44), "7 of about 44 wavenumbers"),
        (("first wavenumbers", 45, 44), "45 wavenumbers"),
        (("first wavenumbers", 45, None), "45 wavenumbers"),
    ],
)
def test_a_step_says_how_far_it_is(stage, text):
    assert step_text(Step(LOWER, *stage)) == text


def test_terminal_shows_a_progress_bar():
    console = Console(file=StringIO(), force_terminal=True, width=120)
    with show_progress(console) as watch:
        watch.on_round([LOWER, UPPER])
        watch.on_step(Step(LOWER, "first wavenumbers", 7, 44))
    assert "lower body: 7 of about 44 wavenumbers" in console.file.getvalue()
    assert "0/2" in console.file.getvalue()


def test_file_output_is_written_by_the_clock_thread(monkeypatch):
    monkeypatch.setattr(progress, "EVERY", 0.02)
    monkeypatch.setattr(progress, "LOOK_EVERY", 0.01)
    line_written, waited = progress.Event(), StringIO()

    class Listening(StringIO):
        def write(self, text):
            if text.strip().endswith(" s"):
                line_written.set()
            return waited.write(text)

    with show_progress(Console(file=Listening(), width=120)) as watch:
        watch.on_step(Step(LOWER, "solid engine at work"))
        assert line_written.wait(10)
    assert f"{NAMES[LOWER]}: solid engine at work, 0 s" in waited.getvalue()


def test_a_model_into_a_file_logs_its_steps(monkeypatch):
    monkeypatch.setattr(progress, "EVERY", 0.0)
    log = StringIO()
    with show_progress(Console(file=log, width=120)) as watch:
        for model in solve_models([(HARMONIC, TASK)], RunOptions(1, watch=watch)):
            watch.on_model(model)
    text = log.getvalue()
    begun, first, done = (text.find(word) for word in ("mesh and assembly", "of about", " unknowns, "))
    assert -1 < begun < first < done


def test_names_of_ics_with_exchanges_are_printed_as_they_are(capsys):
    """Rich takes :B: for a picture of a letter, also without markup."""
    terminal().print("  friction 0.2, Bhat+ns:B: 11 loads")
    assert capsys.readouterr().out == "  friction 0.2, Bhat+ns:B: 11 loads\n"
