"""Capture times that the names of pictures tell."""

from __future__ import annotations

import re
from collections.abc import Sequence
from datetime import UTC, datetime
from fractions import Fraction
from itertools import pairwise
from pathlib import Path

from followspot.csv_rows import DECIMALS
from followspot.errors import InputError

LAST_NUMBER = re.compile(r"([0-9]{1,20}(?:\.[0-9]{1,12})?)[^0-9]*$")
LARGEST = 4_000_000_000 * 10**9
"""ns; the year 2096, and no sum of times overflows."""
EPOCH = datetime(1970, 1, 1, tzinfo=UTC)


def in_order_of_time(files: Sequence[Path], form: str) -> dict[Path, int]:
    """The pictures in the order of their capture, and when each was, ns; form: as `time_of_name` takes it.

    Raises InputError for a name without a time, and for two pictures of one time.
    """
    times = {path: time_of_name(path, form) for path in files}
    ordered = sorted(files, key=times.__getitem__)
    for before, now in pairwise(ordered):
        if times[before] == times[now]:
            text = f"{before} and {now.name} were taken at one time, as their names tell it"
            raise InputError.of(
                text, "choose the pictures of one camera by pattern, or give a finer name_time"
            )
    return {path: times[path] for path in ordered}


def time_of_name(path: Path, form: str) -> int:
    """The time in the name of a picture, ns.

    form: a unit (s, ms, us, ns) of the last number in the name, or what the name without its ending is by the
    letters of `datetime.strptime`; a date without a time zone is UTC. Raises InputError.
    """
    time = _by_unit(path.stem, form) if form in DECIMALS else _by_date(path.stem, form)
    if time is None or not 0 <= time <= LARGEST:
        wanted = f"number in {form}" if form in DECIMALS else f"date {form}"
        raise InputError.of(
            f"{path}: the name has no {wanted}", "give another name_time, or choose pictures by pattern"
        )
    return time


def _by_unit(stem: str, unit: str) -> int | None:
    found = LAST_NUMBER.search(stem)
    return round(Fraction(found[1]) * 10 ** DECIMALS[unit]) if found else None


def _by_date(stem: str, form: str) -> int | None:
    try:
        date = datetime.strptime(stem, form)
    except (ValueError, re.error):
        return None
    passed = (date if date.tzinfo else date.replace(tzinfo=UTC)) - EPOCH
    return ((passed.days * 86_400 + passed.seconds) * 1_000_000 + passed.microseconds) * 1000
