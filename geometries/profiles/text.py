"""Text files of profiles: lines, comments and numbers; errors name the file and the line."""

import re
from dataclasses import dataclass
from pathlib import Path

from geometries.errors import WrongInput

MAX_BYTES = 20_000_000  # of a file; the largest measured profiles have less than 1 MB
MAX_POINTS = 200_000
LARGEST = 1e7  # magnitude of a coordinate in the unit of its file
LONGEST = 64  # number of characters of a number

NUMBER = re.compile(r"[+-]?(?:\d+\.?\d*|\.\d+)(?:[eEdD][+-]?\d+)?", re.ASCII)
NOT_FINITE = re.compile(r"[+-]?(?:nan|inf|infinity)", re.IGNORECASE | re.ASCII)
BINARY = re.compile(rb"[\x00-\x08\x0e-\x1f\x7f]")
QUOTED = re.compile(r"""(?<![^\s,;])(["'])[ \t]*([-+]?\.?\d[-+.,\deEdD]*)[ \t]*\1(?![^\s,;])""")  # a number
LINE_END = re.compile(r"\r\n|\r|\n")


@dataclass(frozen=True)
class Source:
    """A text file as lines without their ends; the first has the number 1."""

    path: Path
    lines: tuple[str, ...]

    def wrong(self, line: int, text: str) -> WrongInput:
        """Error at a line of this file."""
        return WrongInput(f"{self.path}, line {line}: {text}")

    def refused(self, text: str) -> WrongInput:
        """Error of the file as a whole."""
        return WrongInput(f"{self.path}: {text}")


def read_source(path: Path) -> Source:
    """Lines of a text file. Raises WrongInput for what is no file, too large, empty or binary."""
    if "\0" in str(path):
        raise WrongInput(f"path = {str(path)!r}: no path; give the path of a profile")
    try:
        data = _read_bytes(path)
    except OSError as error:
        raise WrongInput(f"{path}: cannot be read ({error.strerror}); give the path of a profile") from None
    return source_of(path, data)


def _read_bytes(path: Path) -> bytes:
    """Content of a file that is not too large."""
    size = path.stat().st_size
    if not path.is_file():
        raise WrongInput(f"{path}: not a file; give the path of a profile")
    if size > MAX_BYTES:
        raise WrongInput(
            f"{path}: {size} bytes; profiles have {MAX_BYTES} at most: thin the points out, or check the path"
        )
    return path.read_bytes()


def source_of(path: Path, data: bytes) -> Source:
    """Lines of the bytes of a file, numbers without quotes. Raises WrongInput where they are no text."""
    data = data.rstrip(b"\x1a")  # end of file of old systems
    if binary := BINARY.search(data):
        line = len(re.findall(rb"\r\n|\r|\n", data[: binary.start()])) + 1
        raise WrongInput(f"{path}, line {line}: byte {binary[0][0]} is no text; save the file as plain text")
    try:
        text = data.decode("utf-8-sig")
    except UnicodeDecodeError:
        text = data.decode("latin-1")
    if not text.strip():
        raise WrongInput(f"{path}, line 1: the file is empty; it must hold the points of a profile")
    return Source(path, tuple(LINE_END.split(QUOTED.sub(r"\2", text))))


def uncommented(line: str, marks: str) -> str:
    """The line before the first of the comment marks, without blanks at its ends."""
    for mark in marks:
        if mark in line:
            line = line.partition(mark)[0]
    return line.strip()


def is_number(token: str) -> bool:
    """Whether a token is written as a finite decimal number."""
    return len(token) <= LONGEST and NUMBER.fullmatch(token) is not None


def number(source: Source, line: int, token: str, name: str) -> float:
    """Value of a token. Raises WrongInput where it is no number, not finite, or huge."""
    if not is_number(token):
        if NOT_FINITE.fullmatch(token):
            raise source.wrong(line, f"{name} = {token}: not a finite number; delete the line or correct it")
        raise source.wrong(
            line, f"{name} = {shortened(token)}: not a number; correct it, or make the line a comment"
        )
    value = as_float(token)
    if not abs(value) <= LARGEST:
        raise source.wrong(line, f"{name} = {shortened(token)}: larger than {LARGEST:g}; correct it")
    return value


def as_float(token: str) -> float:
    """Value of a number, also with the exponents of Fortran (1.0D+00)."""
    return float(token.lower().replace("d", "e"))


def split_columns(source: Source, line: int, text: str) -> list[str]:
    """Fields of a row, separated by blanks, commas or semicolons. Raises WrongInput for decimal commas."""
    if "," not in text and ";" not in text:
        return text.split()
    fields = [field for field in re.split(r"[\s,;]+", text) if field]
    mixed = re.search(r"\d,\d", text) and (re.search(r"\d[\s;]+[-+\d]", text) or text.count(",") > 1)
    if mixed and "." not in text:
        raise source.wrong(
            line, f"{shortened(text)}: looks like decimal commas; write a point before the decimals"
        )
    return fields


def shortened(text: str) -> str:
    """Text in quotes, cut to what fits into a message."""
    return repr(text if len(text) <= 40 else text[:37] + "...")
