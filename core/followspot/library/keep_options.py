"""Options of the flight recorder of a script's run."""

from __future__ import annotations

import re
from dataclasses import dataclass

from followspot.errors import InputError

MIB = 1 << 20
_LONGEST, _LEAST, _MOST = 3600.0, MIB, 1 << 40
_SECONDS = {"ms": 1e-3, "s": 1.0, "min": 60.0}
_BYTES = {"MB": 10**6, "GB": 10**9, "MiB": MIB, "GiB": 1 << 30}
_AMOUNT = re.compile(r"([0-9]+(?:\.[0-9]+)?)\s*([A-Za-z]*)")


@dataclass(frozen=True)
class Keep:
    """Keep the last `seconds` of the ports in memory, for marks.

    ports: STAGE.PORT or a shorter name each, all ports of the graph if none; memory: bytes that messages may
    take, of which pictures are held for a shorter time if they need more; mark_when: conditions that mark by
    themselves, as `--mark-when` takes them.
    """

    seconds: float
    ports: tuple[str, ...] = ()
    memory: int = 512 * MIB
    mark_when: tuple[str, ...] = ()


def seconds_of(text: str, option: str) -> float:
    """Seconds from "30s", "500ms", "2min" or a number. Raises InputError. option: named in it."""
    found = _amount(text, _SECONDS, "s")
    if found is None or not 0.1 <= found <= _LONGEST:
        raise InputError.of(f"{option}: {text!r} is no time from 100ms to 60min", "write for example 30s")
    return found


def bytes_of(text: str, option: str) -> int:
    """Bytes from "512MiB", "2GB" and the like. Raises InputError. option: named in it."""
    found = _amount(text, _BYTES, "")
    if found is None or not _LEAST <= found <= _MOST:
        remedy = "write for example 512MiB or 2GB"
        raise InputError.of(f"{option}: {text!r} is no amount of memory from 1MiB on", remedy)
    return int(found)


def _amount(text: str, units: dict[str, float] | dict[str, int], default: str) -> float | None:
    """A number with a unit, in the unit that counts 1; None if it is none."""
    match = _AMOUNT.fullmatch(text.strip())
    if match is None:
        return None
    scale = units.get(match[2] or default)
    return None if scale is None else float(match[1]) * scale
