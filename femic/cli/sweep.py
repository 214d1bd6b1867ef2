"""The command `sweep`; scenes of a campaign as files, for commands that take scenes."""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable, Iterator
from contextlib import AbstractContextManager, contextmanager
from dataclasses import dataclass
from hashlib import sha256
from pathlib import Path
from time import monotonic
from typing import TYPE_CHECKING, Annotated

import tomlkit
from cyclopts import Parameter
from rich.console import Console
from rich.progress import TextColumn

from compare.campaigns.campaign import Campaign, find_points
from compare.campaigns.load import load_campaign
from femic.cache import folders
from femic.cache.files import write_text
from femic.cache.store import Store
from femic.cli.progress import EVERY, Write, bars, terminal
from femic.cli.work import AT, DEFAULT_WORK, Work, announce, store_at
from femic.lazy import lazy_imports
from geometries.errors import Failure, WrongInput

if TYPE_CHECKING:
    import xarray as xr
    from distributed import Client

    from compare.campaigns.run import Progress

with lazy_imports():
    import compare.campaigns.dataset as datasets
    from compare.campaigns import cluster, plan, run
    from compare.campaigns.report import page
    from compare.pages import ics_results

LONGEST_NAME = 100  # of a file of a scene
SHOWN_FAILURES = 5  # different messages of failures that are printed


@Parameter(name="*")
@dataclass(frozen=True)
class SweepOptions:
    """Options of a campaign besides computing it."""

    plan: Annotated[bool, Parameter(negative="", help="estimate the cost only")] = False
    page: Annotated[bool, Parameter(negative="", help="write the page of the finished scenes only")] = False
    retry: Annotated[bool, Parameter(negative="", help="try failed scenes again")] = False
    write: Annotated[
        str | None,
        Parameter(
            help="write the scenes of these points as files and print their paths: flank=30,ratio=1.1 for "
            "one point, flank=30 for all ratios"
        ),
    ] = None


COMPUTED = SweepOptions()


def sweep(
    campaign: Annotated[
        Path, Parameter(help="campaign file (TOML): a scene, the keys to vary, and their values")
    ],
    /,
    *,
    scheduler: Annotated[
        str | None, Parameter(help="address of a Dask scheduler; default: the cores of this machine")
    ] = None,
    options: SweepOptions = COMPUTED,
    work: Work = DEFAULT_WORK,
) -> None:
    """Compute the scenes of a campaign; write sweep.html and sweep.nc (sweep.zarr where it is large).

    Models that scenes share are solved once. Finished scenes are stored; after an interruption, repeat the
    command to continue. Failed scenes are listed and do not stop the others.
    """
    loaded, console = load_campaign(campaign), terminal()
    if scheduler is not None and work.workers is not None:
        raise WrongInput("--workers counts cores of this machine; leave out --workers or --scheduler")
    address = None if scheduler is None else cluster.parse_address(scheduler)
    folder = folders.check(work.out or Path("out") / loaded.name)
    if options.write is not None:
        for path in write_scenes(loaded, options.write, folder):
            console.print(str(path), soft_wrap=True)
        return
    if options.page:
        path = datasets.dataset_path(folder)
        if not path.exists():
            raise Failure(f"{folder}: no finished scenes yet; leave out --page to start")
        _write_page(datasets.open_undamaged(path), folder, console)
        return
    for combination in plan.require_computable(loaded):
        console.print(f"note: this scene will fail: {combination}", soft_wrap=True)
    store = store_at(work.store, folder)
    if options.plan:
        _print_plan(loaded, store, work.threads, console)
        return
    folders.require_usable(folder)
    if address is not None:
        cluster.require_scheduler(address)

    def note(message: str) -> None:
        console.print(message, soft_wrap=True)

    def client(scenes: int) -> AbstractContextManager[Client]:
        if address is not None:
            return cluster.existing_cluster(address)
        size = cluster.size_for(work.workers, scenes, plan.largest_memory(loaded))
        if size.note:
            note(f"note: {size.note}")
        return cluster.local_cluster(size)

    dataset = datasets.CampaignDataset(loaded, folder)
    with show_campaign(console) as watch:
        progress = run.compute_sweep(dataset, store, client, run.Options(watch, options.retry, note))
    _print_outcome(dataset, progress, console)
    if len(dataset.failures) == loaded.size and not dataset.template.data_vars:
        raise Failure(f"all {loaded.size} scenes failed")
    _write_page(datasets.open_sweep(dataset.path), folder, console)


def _write_page(dataset: xr.Dataset, folder: Path, console: Console) -> None:
    """Write the page of a dataset; a run may go on meanwhile, which locks the folder itself."""
    with folders.locked(folder / "figures"):
        report = page.write_sweep(dataset, folder)
    announce(report, console)


def _print_plan(campaign: Campaign, store: Store, workers: int, console: Console) -> None:
    expected = plan.sweep_plan(campaign, store)
    size = cluster.size_for(workers, expected.scenes, expected.memory)
    rest = expected.scenes - expected.reused
    counted = "" if expected.counted == rest else f" in the first {expected.counted} of them"
    console.print(
        f"{campaign.title}: {expected.scenes} scenes, {expected.reused} of them finished; the others have "
        f"{expected.models} different models{counted}. About {expected.seconds / size.workers:.0f} s with "
        f"{size.workers} workers, {expected.memory:.0f} MB each",
        soft_wrap=True,
    )
    if size.note:
        console.print(f"note: {size.note}", soft_wrap=True)


def _print_outcome(dataset: datasets.CampaignDataset, progress: Progress, console: Console) -> None:
    """Print what was computed, what failed and where the dataset is."""
    console.print(
        f"{progress.scenes} scenes: {progress.finished - progress.failed} computed, {progress.failed} failed "
        f"({progress.reused} by earlier runs). Models: {progress.models} solved, "
        f"{progress.models_reused} times reused"
        + (f"; up to {progress.memory:.0f} MB a worker" if progress.memory else ""),
        soft_wrap=True,
    )
    campaign, counts = dataset.campaign, Counter(dataset.failures.values())
    for message, count in counts.most_common(SHOWN_FAILURES):
        first = min(number for number, failure in dataset.failures.items() if failure == message)
        others = f" and {count - 1} more" if count > 1 else ""
        point = campaign.point_name(campaign.point(first))
        console.print(f"failed: {point}{others}: {message}", soft_wrap=True)
    if len(counts) > SHOWN_FAILURES:
        console.print(f"and {len(counts) - SHOWN_FAILURES} other messages: `failure` in the dataset")
    console.print(f"Dataset: {dataset.path}", soft_wrap=True)


# --- progress -------------------------------------------------------------------------------------------


@contextmanager
def show_campaign(console: Console) -> Iterator[Callable[[Progress], None]]:
    """Yield a function that shows the progress of a campaign: by a bar on a terminal, otherwise by lines."""
    if not console.is_terminal:
        yield campaign_lines(lambda text: console.print(text, soft_wrap=True))
        return
    with bars(console, TextColumn("{task.fields[time_left]}")) as shown:
        scenes = shown.add_task("scenes", total=None, time_left="")

        def show(progress: Progress) -> None:
            counts, time_left = _texts(progress)
            shown.update(
                scenes,
                total=progress.scenes,
                completed=progress.finished,
                description=f"scenes ({counts})",
                time_left=time_left,
            )

        yield show


def campaign_lines(write: Write, clock: Callable[[], float] = monotonic) -> Callable[[Progress], None]:
    """Return a function that writes a line about progress every EVERY seconds, and at the end."""
    last = -EVERY

    def write_if_due(progress: Progress) -> None:
        nonlocal last
        if (now := clock()) - last >= EVERY or progress.finished == progress.scenes:
            last = now
            counts, time_left = _texts(progress)
            line = f"  {progress.finished} of {progress.scenes} scenes ({counts})"
            write(", ".join(filter(None, (line, time_left))))

    return write_if_due


def _texts(progress: Progress) -> tuple[str, str]:
    """Return texts about the scenes and models of a campaign, and about the time left, "" if not known."""
    counts = (
        f"{progress.reused} finished before, {progress.failed} failed; models: {progress.models} solved, "
        f"{progress.models_reused} times reused"
    )
    seconds = progress.seconds_left
    if not seconds:
        return counts, ""
    return counts, f"about {seconds:.0f} s left" if seconds < 180 else f"about {seconds / 60:.0f} min left"


# --- scenes of a campaign as files -----------------------------------------------------------------------


def write_scenes(campaign: Campaign, name: str, folder: Path) -> list[Path]:
    """Return the files of the scenes at some points, in a folder; raise BadScene before any is written.

    They are as the campaign computes them, without the check by the other engine.
    """
    points, paths = find_points(campaign, name), []
    for point in points:
        campaign.scene(point)
    for point in points:
        table, file = campaign.scene_table(point), campaign.point_name(point)
        if table.get("engine", {}).get("check"):
            table = table | {"engine": table["engine"] | {"check": False}}
        if len(file) > LONGEST_NAME:
            file = f"{file[:LONGEST_NAME]}_{sha256(file.encode()).hexdigest()[:8]}"
        path = folders.make(folder) / f"{file.replace('/', '_')}.toml"
        paths.append(write_text(tomlkit.dumps(table), path))
    return paths


def find_scenes(argument: str, results: Path) -> dict[str, str | None]:
    """Return the scenes of an argument, and the store of the models of each; None: no store yet.

    The scenes are the argument itself, or files of points of a campaign such as CAMPAIGN.toml@flank=30,
    some of whose models the campaign has stored.
    """
    file, at, name = argument.rpartition(AT)
    if not at or Path(argument).exists():
        return {argument: None}
    campaign = load_campaign(Path(file))
    count, most = len(find_points(campaign, name)), ics_results.MOST_SCENES
    if count > most:
        raise WrongInput(f"{argument}: {count} scenes; at most {most} are compared: name another axis")
    folder = results / campaign.name
    store = str(folder / "store") if (folder / "store").is_dir() else None
    return {str(path): store for path in write_scenes(campaign, name, folder)}
