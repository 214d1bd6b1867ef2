"""The commands of femic as Markdown, from the program."""

from typing import Any

from femic.cli.main import COMMANDS, app

FIRST = "## femic "  # where the page of the first command begins


def command_line() -> dict[str, Any]:
    """Return what the page on the command line shows, by the names of its template."""
    text = app.generate_docs(output_format="markdown").replace("```console", "```")
    return {
        "commands": {name: help_text for name, (_, help_text) in COMMANDS.items()},
        "command_pages": text[text.index(FIRST) :].strip(),
    }
