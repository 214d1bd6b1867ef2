"""Progress of campaigns: a bar on a terminal, otherwise a line every few seconds."""

from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from time import monotonic

from rich.console import Console
from rich.progress import TextColumn

from compare.campaigns.run import Progress
from femic.cli.progress import EVERY, Write, bars


@contextmanager
def show_campaign(console: Console) -> Iterator[Callable[[Progress], None]]:
    """Yield a function that shows the progress of a campaign: by a bar on a terminal, otherwise by lines."""
    if not console.is_terminal:
        yield CampaignLines(lambda text: console.print(text, soft_wrap=True)).write_if_due
        return
    with bars(console, TextColumn("{task.fields[time_left]}")) as shown:
        scenes = shown.add_task("scenes", total=None, time_left="")

        def show(progress: Progress) -> None:
            shown.update(
                scenes,
                total=progress.scenes,
                completed=progress.finished,
                description=f"scenes ({counts(progress)})",
                time_left=time_left(progress),
            )

        yield show


@dataclass
class CampaignLines:
    """Lines about the progress of a campaign: every EVERY seconds, and at the end."""

    write: Write
    clock: Callable[[], float] = monotonic
    _last: float = -EVERY

    def write_if_due(self, progress: Progress) -> None:
        """Write a line if the last one is old, or if all is done."""
        if self.clock() - self._last >= EVERY or progress.finished == progress.scenes:
            self._last = self.clock()
            line = f"  {progress.finished} of {progress.scenes} scenes ({counts(progress)})"
            self.write(", ".join(text for text in (line, time_left(progress)) if text))


def counts(progress: Progress) -> str:
    """Return text about the scenes and models of a campaign."""
    return (
        f"{progress.reused} finished before, {progress.failed} failed; models: {progress.models} solved, "
        f"{progress.models_reused} times reused"
    )


def time_left(progress: Progress) -> str:
    """Return text about the time that is left; "" where it is not known, and at the end."""
    seconds = progress.seconds_left
    if not seconds:
        return ""
    return f"about {seconds:.0f} s left" if seconds < 180 else f"about {seconds / 60:.0f} min left"
