"""Files of figures, which are written on request only: pages draw their charts themselves."""

from collections.abc import Iterable, Iterator, Sequence
from contextlib import contextmanager
from contextvars import ContextVar
from pathlib import Path

from compare.report.charts import Chart
from femic.cache import folders
from femic.cache.files import replacing
from femic.lazy import lazy_imports

with lazy_imports():
    from compare.report import static

_formats: ContextVar[tuple[str, ...]] = ContextVar("formats of the files of figures", default=())


@contextmanager
def figures_as(formats: Sequence[str]) -> Iterator[None]:
    """Write every figure in some formats, such as "pdf" and "svg", within this context."""
    token = _formats.set(tuple(formats))
    try:
        yield
    finally:
        _formats.reset(token)


def figures_wanted() -> bool:
    """Whether files of figures are asked for."""
    return bool(_formats.get())


def save_charts(charts: Iterable[Chart], folder: Path, prefix: str = "") -> None:
    """Write the figures of charts, drawn for paper, into a folder in the formats asked for, if any."""
    for chart in charts if _formats.get() else ():
        folders.make(folder)
        for name, figure in static.pictures(chart).items():
            for form in _formats.get():
                with replacing(folder / f"{prefix}{name}.{form}") as unfinished:
                    figure.savefig(unfinished, format=form)
