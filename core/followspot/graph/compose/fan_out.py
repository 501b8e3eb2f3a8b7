"""The uses of a graph file that one entry of `stages` stands for, as the room has cameras and members."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field

from followspot.errors import Mistake
from followspot.graph.compose.narrowing import Limit, narrowed, read_cameras
from followspot.graph.names import below
from followspot.graph.selector import Selector, read_selector
from followspot.room import Member, Room
from followspot.yaml.form import Form
from followspot.yaml.node import Node


@dataclass(frozen=True)
class UseContext:
    """What the file that uses a graph file tells of it.

    room: None if it has mistakes; named: whether the graph names a room; prefix: full name of the sub-graph
    around the use, "" for the graph itself; limits: of that sub-graph.
    """

    room: Room | None
    named: bool
    prefix: str
    limits: tuple[Limit, ...]


@dataclass(frozen=True)
class Use:
    """One use of a file. name: within the sub-graph around it; limits: the cameras and members it serves."""

    name: str
    limits: tuple[Limit, ...]
    optional: bool


@dataclass(frozen=True)
class FanOut:
    """left_out: uses that the room has nothing for, each with the reason; the stage if none is left.

    complete: False if one use stands for all members, which are not known.
    """

    uses: tuple[Use, ...]
    left_out: Mapping[str, Mistake] = field(default_factory=dict)
    complete: bool = True


def fan_out(stage: str, entry: Form, around: UseContext, mistakes: list[Mistake]) -> FanOut:
    """The uses that the entry of a sub-graph stands for: one, or one for each member that it names.

    If the room is not known, one use stands for all.
    """
    optional = entry.switch("optional")
    cameras, each = entry.get("cameras"), entry.get("each")
    chosen = None if cameras is None else read_cameras(cameras, mistakes)
    limits = around.limits if chosen is None else (*around.limits, chosen)
    if around.room is None:
        return FanOut((Use(stage, limits, optional),), complete=each is None)
    members: Sequence[Member | None] = (None,)
    if each is not None:
        selector = read_selector(narrowed(each, limits), mistakes)
        members = selector.select(around.room) if selector.readable else ()
        if selector.readable and not members:
            if optional:
                return FanOut((), {stage: _absent(stage, selector, around)})
            mistakes.append(_lacking(below(around.prefix, stage), selector, "fans out over", around))
    uses = {name: Use(name, own, optional) for name, own in _limits(stage, members, limits)}
    if cameras is None or chosen is None:
        return FanOut(tuple(uses.values()))
    unserved = _without_cameras(_limits(stage, members, around.limits), cameras, around.room)
    if unserved and not optional:
        name, seen = next(iter(unserved.items()))
        mistakes.append(_lacking(below(around.prefix, name), seen, "serves", around))
        return FanOut(())
    served = tuple(use for name, use in uses.items() if name not in unserved)
    if unserved and not served:
        unserved = {stage: read_selector(narrowed(cameras, around.limits), [])}
    return FanOut(served, {name: _absent(name, seen, around) for name, seen in unserved.items()})


def _limits(
    stage: str, members: Sequence[Member | None], limits: tuple[Limit, ...]
) -> Iterator[tuple[str, tuple[Limit, ...]]]:
    """The name and the limits of each use: the given ones, and its member, if it is of one."""
    for member in members:
        yield (stage, limits) if member is None else (f"{stage}/{member.name}", (*limits, member))


def _without_cameras(
    uses: Iterable[tuple[str, tuple[Limit, ...]]], cameras: Node, room: Room
) -> dict[str, Selector]:
    """The uses for which the room has none of the wanted cameras, each with the selector."""
    wanted = {name: read_selector(narrowed(cameras, limits), []) for name, limits in uses}
    return {name: selector for name, selector in wanted.items() if not selector.select(room)}


def _absent(name: str, wanted: Selector, around: UseContext) -> Mistake:
    text = f'sub-graph "{below(around.prefix, name)}" is left out: the room has no {wanted.text}'
    return Mistake(wanted.place, text)


def _lacking(name: str, wanted: Selector, verb: str, around: UseContext) -> Mistake:
    """The mistake of a sub-graph that asks for members which the room lacks; verb: how it asks."""
    if not around.named or around.room is None:
        text = f'sub-graph "{name}" {verb} {wanted.text}, but the graph names no room'
        return Mistake(wanted.place, text, "add room: FILE.yaml")
    text = f'sub-graph "{name}" {verb} {wanted.text}, and the room "{around.room.name}" has none'
    remedy = f"{wanted.choices(around.room)}; or write optional: true"
    return wanted.unknown(around.room) or Mistake(wanted.place, text, remedy)
