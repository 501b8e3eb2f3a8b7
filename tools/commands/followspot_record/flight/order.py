"""The order that a flight recorder's process reads from its standard input, as JSON."""

from collections.abc import Mapping

import pydantic


class FlightOrder(pydantic.BaseModel, frozen=True):
    """run: beginning of its name, or the process id of its operator; period: s that are kept; limit: bytes
    in memory; ports: words that name them, all ports if none; mark_when: conditions that mark; files:
    embedded in recordings, by name.
    """

    run: str
    period: float
    limit: int
    ports: tuple[str, ...] = ()
    mark_when: tuple[str, ...] = ()
    files: Mapping[str, str] = {}


class FlightEnd(pydantic.BaseModel, frozen=True):
    """The last line that the process reads: the run is over. errors: why it failed, empty if it did not."""

    errors: tuple[str, ...] = ()
