"""The commands of femic as Markdown, from the program."""

import re
from collections import Counter
from dataclasses import dataclass
from typing import Any

from femic.cli.main import app

COMMAND = re.compile(r"^## (femic .*)$", flags=re.MULTILINE)
ENTRY = re.compile(r"^\* `([^`]*)`(.*)$", flags=re.MULTILINE)  # an argument or an option
ARTEFACTS = re.compile(r", --scene| \*\[default: (?:\(.*\)|False)\]\*| \*\*\[required\]\*\*")
SHARED = 5  # commands that have an entry, from which on it is shown once


@dataclass(frozen=True)
class Command:
    """A command: its name, how it is called, what it does, lines on its arguments and options."""

    name: str
    usage: str
    help_text: str
    entries: list[str]


def command_line() -> dict[str, Any]:
    """Return what the page on the command line shows, by the names of its template.

    Entries that many commands have are shown once: `shared_entries`, beside the
    names of the commands that have all of these options.
    """
    parts = COMMAND.split(app.generate_docs(output_format="markdown"))[1:]
    commands = [command(name, text) for name, text in zip(parts[::2], parts[1::2], strict=True)]
    counts = Counter(entry for each in commands for entry in each.entries)
    shared = [entry for entry, count in counts.items() if count >= SHARED]
    common = [entry for entry in shared if entry.startswith("`--")]
    (scene,) = (entry for entry in shared if entry not in common)
    having = [each.name for each in commands if set(common) <= set(each.entries)]
    for each in commands:
        shown_once = [scene, *common] if each.name in having else [scene]
        each.entries[:] = [entry for entry in each.entries if entry not in shown_once]
    return {"commands": commands, "shared_entries": [scene, *common], "having_common": having}


def command(name: str, text: str) -> Command:
    """Return a command from its part of the program's Markdown."""
    called, _, rest = text.partition("```console\n")[2].partition("\n```\n")
    entries = [f"`{shown(entry)}`{shown(meaning)}" for entry, meaning in ENTRY.findall(rest)]
    called = called.replace(f"{name} {name.removeprefix('femic ')}", name)  # where the usage is given
    return Command(name, called, rest.strip().split("\n")[0], entries)


def shown(text: str) -> str:
    """Return a part of an entry without what only the program needs."""
    return ARTEFACTS.sub("", text)
