"""The state of PTP (IEEE 1588) of a camera, read from its features."""

from __future__ import annotations

from collections.abc import Callable, Collection, Sequence
from dataclasses import dataclass


@dataclass(frozen=True)
class PtpFeatures:
    """Names of features. switch: whether the camera takes part; latch: the command after which the data are
    of one moment; state, offset: of its clock from the master's, ns; each as latched first, then as it is.
    """

    switch: str
    latch: str
    state: Sequence[str]
    offset: Sequence[str]


KNOWN = (
    PtpFeatures("PtpEnable", "PtpDataSetLatch", ("PtpStatus",), ("PtpOffsetFromMaster",)),
    PtpFeatures(
        "GevIEEE1588",
        "GevIEEE1588DataSetLatch",
        ("GevIEEE1588StatusLatched", "GevIEEE1588Status"),
        ("GevIEEE1588OffsetFromMasterLatched", "GevIEEE1588OffsetFromMaster"),
    ),
)
"""Of SFNC 2, and of GigE Vision cameras before it (Basler, FLIR)."""


def ptp_state(names: Collection[str], read: Callable[[str], str], execute: Callable[[str], None]) -> str:
    """The camera's state of PTP, for example "Slave, 120 ns from its master"; "off", or "" if it has none.

    names: of all its features; read: the value of one; execute: runs a command, which a camera that another
    program controls refuses: then what it says without it counts.
    """
    known = next((one for one in KNOWN if one.switch in names), None)
    if known is None:
        return ""
    if read(known.switch).lower() not in ("true", "1", "on"):
        return "off"
    order = 1 if known.latch in names and _latched(execute, known.latch) else -1
    state = next((read(name) for name in known.state[::order] if name in names), "on")
    offset = next((int(float(read(name))) for name in known.offset[::order] if name in names), None)
    follows = state == "Slave" and offset is not None
    return f"{state}, {offset} ns from its master" if follows else state


def ptp_problem(names: Collection[str], read: Callable[[str], str], execute: Callable[[str], None]) -> str:
    """Why the clock of a camera follows no PTP master; "" if it does, if it is one, or without PTP.

    Arguments are those of `ptp_state`. Raises ConnectionError if the camera is gone.
    """
    try:
        state = ptp_state(names, read, execute)
    except ValueError:  # a node that cannot be read now
        return ""
    in_step = state in ("", "off", "on", "Master") or state.startswith("Slave")
    return "" if in_step else f"its PTP is {state}: its clock follows no master"


def _latched(execute: Callable[[str], None], command: str) -> bool:
    """Whether the camera takes the command."""
    try:
        execute(command)
    except (ConnectionError, ValueError):
        return False
    return True
