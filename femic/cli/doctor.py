"""`femic doctor` checks whether an installation is complete, femic's own, and right."""

from rich.table import Table
from rich.text import Text

from femic.cli.terminal import terminal
from femic.installation import findings
from geometries.errors import Failure

OK, NO, LACKING = Text("ok", "green"), Text("no", "red"), Text("–", "yellow")


def doctor() -> None:
    """Check libraries, versions, import names, and two results with known values; takes some 10 s."""
    console = terminal()
    wrong = []
    table = Table(box=None, pad_edge=False, show_header=False)
    with console.status("checking"):
        for finding in findings():
            mark = OK if finding.holds else NO if finding.matters else LACKING
            remedy = "" if finding.holds else f"\n→ {finding.remedy}"
            table.add_row(mark, finding.name, f"{finding.text}{remedy}")
            if not finding.holds and finding.matters:
                wrong.append(finding.name)
    console.print(table)
    if wrong:
        raise Failure(f"this installation is not in order: {', '.join(wrong)}")
    console.print("This installation is in order.")
