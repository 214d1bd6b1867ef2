"""Shows how far a campaign is: a bar on a terminal, otherwise a line every few seconds."""

from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from time import monotonic

from rich.console import Console
from rich.progress import BarColumn, MofNCompleteColumn, SpinnerColumn, TextColumn, TimeElapsedColumn
from rich.progress import Progress as Bars

from femic.campaigns.running.run import Progress
from femic.cli.progress import EVERY, Write


@contextmanager
def campaign_shown(console: Console) -> Iterator[Callable[[Progress], None]]:
    """A function that shows how far a campaign is: a bar on a terminal, otherwise a line every EVERY s."""
    if not console.is_terminal:
        yield CampaignLines(lambda text: console.print(text, soft_wrap=True, markup=False)).tell
        return
    columns = SpinnerColumn(), TextColumn("{task.description}"), BarColumn(), MofNCompleteColumn()
    with Bars(*columns, TimeElapsedColumn(), TextColumn("{task.fields[left]}"), console=console) as bars:
        scenes = bars.add_task("scenes", total=None, left="")

        def show(progress: Progress) -> None:
            bars.update(
                scenes,
                total=progress.scenes,
                completed=progress.finished,
                description=f"scenes ({of_which(progress)})",
                left=left(progress),
            )

        yield show


@dataclass
class CampaignLines:
    """Writes how far a campaign is: EVERY seconds, and when it is finished."""

    write: Write
    clock: Callable[[], float] = monotonic
    _last: float = -EVERY

    def tell(self, progress: Progress) -> None:
        """Write a line if the last one is old, or if all is done."""
        if self.clock() - self._last >= EVERY or progress.finished == progress.scenes:
            self._last = self.clock()
            line = f"  {progress.finished} of {progress.scenes} scenes ({of_which(progress)})"
            self.write(", ".join(text for text in (line, left(progress)) if text))


def of_which(progress: Progress) -> str:
    """Text about the scenes and models of a campaign."""
    return (
        f"{progress.reused} kept, {progress.failed} failed; models: {progress.models} solved, "
        f"{progress.models_reused} times kept"
    )


def left(progress: Progress) -> str:
    """Text about the time that is left; "" where it is not known, and at the end."""
    seconds = progress.seconds_left
    if not seconds:
        return ""
    return f"about {seconds:.0f} s left" if seconds < 180 else f"about {seconds / 60:.0f} min left"
