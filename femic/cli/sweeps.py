"""The command `sweep`."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterator
from contextlib import AbstractContextManager, contextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

from cyclopts import Parameter
from rich.console import Console

from femic.cache import folders
from femic.cache.store import Store
from femic.campaigns.files.campaign import Campaign
from femic.campaigns.files.load import load_campaign
from femic.cli.work import DEFAULT_WORK, Work, kept
from femic.late import Late
from geometries.errors import Failure, WrongInput

if TYPE_CHECKING:
    import xarray as xr
    from distributed import Client

    from femic.campaigns.dataset.collected import Collected
    from femic.campaigns.running.run import Progress

existing_cluster = Late("femic.campaigns.running.cluster:existing_cluster")
local_cluster = Late("femic.campaigns.running.cluster:local_cluster")
size_for = Late("femic.campaigns.running.cluster:size_for")
ComputeOptions = Late("femic.campaigns.running.run:Options")
compute_sweep = Late("femic.campaigns.running.run:compute_sweep")
impossible = Late("femic.campaigns.running.checks:impossible")
require_computable = Late("femic.campaigns.running.checks:require_computable")
collect = Late("femic.campaigns.dataset.collected:Collected")
file_in = Late("femic.campaigns.dataset.reading:file_in")
open_sweep = Late("femic.campaigns.dataset.reading:open_sweep")
largest_memory = Late("femic.campaigns.running.plan:largest_memory")
planned = Late("femic.campaigns.running.plan:planned")
write_sweep = Late("femic.campaigns.report.page:write_sweep")
address_of = Late("femic.campaigns.running.scheduler:address_of")
require_scheduler = Late("femic.campaigns.running.scheduler:require_scheduler")
require_undamaged = Late("femic.campaigns.dataset.integrity:require_undamaged")
REMEDY = Late("femic.campaigns.dataset.integrity:REMEDY")
campaign_shown = Late("femic.cli.campaign_progress:campaign_shown")
written = Late("femic.cli.points:written")

SHOWN_FAILURES = 5  # kinds of failures that are printed


@Parameter(name="*")
@dataclass(frozen=True)
class SweepOptions:
    """What to do with a campaign besides computing it."""

    plan: Annotated[bool, Parameter(negative="", help="say what it would take, and compute nothing")] = False
    page: Annotated[
        bool, Parameter(negative="", help="write the page of what is finished so far, and compute nothing")
    ] = False
    retry: Annotated[bool, Parameter(negative="", help="try scenes again that failed before")] = False
    write: Annotated[
        str | None,
        Parameter(
            help="such as flank=30,ratio=1.1, or flank=30 for all ratios: write the scenes of these points "
            "as files, print their paths"
        ),
    ] = None


COMPUTED = SweepOptions()


def sweep(
    campaign: Annotated[Path, Parameter(help="campaign file (TOML): a scene, keys that are swept, values")],
    /,
    *,
    scheduler: Annotated[
        str | None, Parameter(help="address of a Dask scheduler; default: the cores of this machine")
    ] = None,
    options: SweepOptions = COMPUTED,
    work: Work = DEFAULT_WORK,
) -> None:
    """Compute the scenes of a campaign; write sweep.html and sweep.nc (sweep.zarr where it is large).

    Models that scenes share are solved once, and finished scenes are kept: the same command goes on after an
    interruption. Scenes that fail are listed, and do not stop the others.
    """
    loaded, console = load_campaign(campaign), Console(highlight=False)
    if scheduler is not None and work.workers is not None:
        raise WrongInput("--workers is of this machine's cores: leave it out, or --scheduler")
    address = None if scheduler is None else address_of(scheduler)
    folder = folders.check(work.out or Path("out") / loaded.name)
    if options.write is not None:
        for path in written(loaded, options.write, folder):
            console.print(str(path), markup=False, soft_wrap=True)
        return
    if options.page:
        _show(_undamaged(folder), folder, console)
        return
    require_computable(loaded)
    for combination in impossible(loaded):
        console.print(f"note: a scene that will fail: {combination}", markup=False, soft_wrap=True)
    store = kept(work.store, folder)
    if options.plan:
        _show_plan(loaded, store, work.threads, console)
        return
    folders.require_usable(folder)

    if address is not None:
        require_scheduler(address)

    def note(message: str) -> None:
        console.print(message, markup=False, soft_wrap=True)

    def cluster(scenes: int) -> AbstractContextManager[Client]:
        if address is not None:
            return existing_cluster(str(address))
        return _local(loaded, scenes, work.workers, console)

    collected = collect(loaded, folder)
    with campaign_shown(console) as told:
        done = compute_sweep(collected, store, cluster, ComputeOptions(told, options.retry, note))
    _tell(collected, done, console)
    if len(collected.failures) == loaded.size and not collected.template.data_vars:
        raise Failure(f"all {loaded.size} scenes failed")
    _show(open_sweep(collected.path), folder, console)


def _undamaged(folder: Path) -> xr.Dataset:
    """The dataset in a folder; raises Failure where there is none, or a damaged one."""
    path = file_in(folder)
    if not path.exists():
        raise Failure(f"{folder}: nothing is finished yet: leave out --page to begin")
    try:
        dataset = open_sweep(path)
    except Exception as error:  # whatever zarr and xarray make of it
        raise Failure(f"{path}: damaged ({error}): {REMEDY.resolved}") from error
    require_undamaged(path, dataset)
    return dataset


def _show(dataset: xr.Dataset, folder: Path, console: Console) -> None:
    """Write the page of a dataset, also while a run goes on, which locks the folder itself."""
    with folders.locked(folder / "figures"):
        report = write_sweep(dataset, folder)
    console.print(f"Report: {report}", markup=False, soft_wrap=True)


@contextmanager
def _local(campaign: Campaign, scenes: int, workers: int | None, console: Console) -> Iterator[Client]:
    """A cluster of this machine's cores, as many as the largest models leave room for."""
    size = size_for(workers, scenes, largest_memory(campaign))
    if size.note:
        console.print(f"note: {size.note}", markup=False, soft_wrap=True)
    with local_cluster(size) as client:
        yield client


def _show_plan(campaign: Campaign, store: Store, workers: int, console: Console) -> None:
    takes = planned(campaign, store)
    size = size_for(workers, takes.scenes, takes.memory)
    counted = "" if takes.counted == takes.scenes - takes.reused else f" in the first {takes.counted} of them"
    console.print(
        f"{campaign.title}: {takes.scenes} scenes, {takes.reused} of them kept; the others have "
        f"{takes.models} different models{counted}. About {takes.seconds / size.workers:.0f} s with "
        f"{size.workers} workers, {takes.memory:.0f} MB each",
        markup=False,
        soft_wrap=True,
    )
    if size.note:
        console.print(f"note: {size.note}", markup=False, soft_wrap=True)


def _tell(collected: Collected, done: Progress, console: Console) -> None:
    """Print what was computed, what failed and where the dataset is."""
    console.print(
        f"{done.scenes} scenes: {done.finished - done.failed} computed, {done.failed} failed "
        f"({done.reused} by earlier runs). Models: {done.models} solved, {done.models_reused} times kept"
        + (f"; up to {done.memory:.0f} MB a worker" if done.memory else ""),
        soft_wrap=True,
    )
    campaign, kinds = collected.campaign, Counter(collected.failures.values())
    for message, count in kinds.most_common(SHOWN_FAILURES):
        first = min(number for number, found in collected.failures.items() if found == message)
        others = f" and {count - 1} more" if count > 1 else ""
        console.print(
            f"failed: {campaign.named(campaign.point(first))}{others}: {message}",
            markup=False,
            soft_wrap=True,
        )
    if len(kinds) > SHOWN_FAILURES:
        console.print(f"and {len(kinds) - SHOWN_FAILURES} other messages: `failure` in the dataset")
    console.print(f"Dataset: {collected.path}", markup=False, soft_wrap=True)
