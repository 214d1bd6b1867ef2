"""Files of figures: SVG, which pages show on paper, and further formats on request."""

from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from contextvars import ContextVar
from pathlib import Path

from matplotlib.figure import Figure

from femic.cache.files import replacing

_further: ContextVar[tuple[str, ...]] = ContextVar("further formats of figures", default=())


@contextmanager
def figures_as(formats: Sequence[str]) -> Iterator[None]:
    """Write every figure also in further formats, such as "pdf" and "png", within this context."""
    token = _further.set(tuple(formats))
    try:
        yield
    finally:
        _further.reset(token)


def save(figure: Figure, path: Path) -> Path:
    """Write a figure in the format of its path's ending, and return the path."""
    with replacing(path) as unfinished:
        figure.savefig(unfinished, format=path.suffix[1:])
    return path


def save_all(figure: Figure, path: Path) -> Path:
    """Write a figure as SVG and in all formats asked for; the path has no ending; returns the SVG."""
    for name in _further.get():
        if name != "svg":
            save(figure, path.with_name(f"{path.name}.{name}"))
    return save(figure, path.with_name(f"{path.name}.svg"))
