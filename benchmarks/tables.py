"""Tables in Markdown."""

from collections.abc import Iterable, Sequence


def print_table(head: Sequence[str], rows: Iterable[Sequence[object]], title: str = "") -> None:
    """Print a table, each row as soon as it is there."""
    if title:
        print(f"\n### {title}")
    print(f"\n{line_of(head)}\n|{'---|' * len(head)}", flush=True)
    for row in rows:
        print(line_of(row), flush=True)


def line_of(cells: Sequence[object]) -> str:
    """Return a line of a table."""
    return f"| {' | '.join(map(str, cells))} |"
