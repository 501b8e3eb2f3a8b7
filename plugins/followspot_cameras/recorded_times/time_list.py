"""Time stamps of pictures as a list, one a line: the format of mkvmerge and of Raspberry Pi's cameras."""

from __future__ import annotations

import re
from fractions import Fraction
from itertools import pairwise
from pathlib import Path

from followspot.csv_rows import MOST_ROWS
from followspot.errors import InputError, Mistake, Place
from followspot.files import open_text

HEADER = re.compile(r"# time(code|stamp) format v2\s*")
NUMBER = re.compile(r"[0-9]{1,18}(\.[0-9]{1,18})?")
LARGEST = 4_000_000_000_000
"""ms; some 126 years, so that no sum of times overflows."""
REMEDY = 'the first line is "# timestamp format v2", each other line a time in ms, as mkvmerge writes them'


def read_time_list(path: Path) -> list[int]:
    """Capture times, ns, of the pictures of a recording, in the order of their capture.

    A file of mkvmerge lists times in the order of the file, which is another where pictures were coded out of
    order; players sort them, and so does this. Raises InputError with file, line and remedy.
    """
    try:
        with open_text(path) as file:
            lines = [line.strip() for line, _ in zip(file, range(MOST_ROWS + 2), strict=False)]
    except OSError as error:
        raise InputError.of(f"{path} cannot be read: {error.strerror}", REMEDY) from None
    except UnicodeDecodeError:
        raise InputError.of(f"{path} is no list of time stamps", REMEDY) from None
    if not lines or not HEADER.fullmatch(lines[0]):
        raise _wrong(path, 1, "this is no list of time stamps of format v2", REMEDY)
    if len(lines) > MOST_ROWS + 1:
        raise _wrong(path, MOST_ROWS + 2, f"more than {MOST_ROWS} rows", "split the recording")
    found = sorted(
        (_nanoseconds(path, number, line), number)
        for number, line in enumerate(lines[1:], 2)
        if line and not line.startswith("#")
    )
    if not found:
        raise _wrong(path, 1, "no time stamp", REMEDY)
    for (before, _), (now, number) in pairwise(found):
        if now == before:
            raise _wrong(path, number, "this time stands twice", "one line for each picture")
    return [time for time, _ in found]


def _nanoseconds(path: Path, number: int, line: str) -> int:
    """A time in ms as ns. Raises InputError.

    A decimal number would set a context variable, and numpy then takes longer to find its own in every call.
    """
    if not NUMBER.fullmatch(line) or (milliseconds := Fraction(line)) > LARGEST:
        raise _wrong(path, number, f'"{line[:40]}" is no time in ms', REMEDY)
    return round(milliseconds * 1_000_000)


def _wrong(path: Path, line: int, text: str, remedy: str) -> InputError:
    return InputError([Mistake(Place(str(path), line, 1), text, remedy)])
