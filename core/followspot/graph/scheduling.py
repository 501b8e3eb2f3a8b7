"""How the operating system schedules a worker: its cores, its priority, real time."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Annotated

from pydantic import Field

from followspot.yaml.form import Form, kind_of
from followspot.yaml.node import Node

KEYS = ("cores", "nice", "realtime")
MAX_CORE = 1023
NICE = -20, 19
REALTIME = 1, 99


@dataclass(frozen=True)
class Scheduling:
    """The scheduling that a worker asks of its host; the default asks for nothing."""

    cores: tuple[Annotated[int, Field(ge=0, le=MAX_CORE)], ...] = ()
    """Cores that it may run on; empty for all."""
    nice: Annotated[int, Field(ge=NICE[0], le=NICE[1])] = 0
    """Priority among ordinary processes: 19 yields to all others, negative values need a right."""
    realtime: Annotated[int, Field(ge=0, le=REALTIME[1])] = 0
    """Priority of SCHED_FIFO, before all ordinary processes; 0 for none."""

    def __str__(self) -> str:
        words = [f"cores {' '.join(map(str, self.cores))}"] if self.cores else []
        words += [f"nice {self.nice}"] if self.nice else []
        words += [f"real-time {self.realtime}"] if self.realtime else []
        return ", ".join(words)


def read_scheduling(form: Form) -> Scheduling:
    """The scheduling that a placement file gives a worker; notes mistakes."""
    nice = form.whole("nice", least=NICE[0], most=NICE[1])
    realtime = form.whole("realtime", least=REALTIME[0], most=REALTIME[1])
    if nice is not None and realtime is not None:
        text = f"{form.noun} has nice and realtime; nice means nothing to a real-time worker"
        form.unfit("nice", text, "remove one")
    return Scheduling(_cores(form), nice or 0, realtime or 0)


def _cores(form: Form) -> tuple[int, ...]:
    """The cores of a worker; notes mistakes."""
    node = form.get("cores")
    if node is None:
        return ()
    if not isinstance(node.value, tuple) or not node.value:
        form.wrong(node, f"cores is a list of numbers, not {kind_of(node)}", "cores: [0, 1]")
        return ()
    found: list[int] = []
    for item in node.value:
        core = _core(item)
        if core is None:
            form.wrong(item, f"a core cannot be {kind_of(item)}", f"write whole numbers from 0 to {MAX_CORE}")
        elif core in found:
            form.wrong(item, f"core {core} is named twice", "name it once")
        else:
            found.append(core)
    return tuple(found)


def _core(node: Node) -> int | None:
    value = node.value
    whole = isinstance(value, int) and not isinstance(value, bool)
    return value if whole and 0 <= value <= MAX_CORE else None  # type: ignore[operator,return-value]
