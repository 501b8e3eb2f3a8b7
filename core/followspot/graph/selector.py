"""`each: cameras[kind=color, zone=hall|stage]`: which members of the room a stage fans out over.

A selector names a set (`cameras`, `sensors`, `targets`) or a tag (`zones` for the tag `zone`), then
conditions that all must hold. A condition asks for a property or a tag. The members of a tag are its values;
their conditions apply to the cameras and sensors that carry the tag, `name` to the value itself.
"""

from __future__ import annotations

import re
from collections.abc import Iterable, Mapping
from dataclasses import dataclass, replace

from followspot.errors import Mistake, Place, did_you_mean
from followspot.room import SETS, Camera, Member, Room, Sensor, Target
from followspot.yaml.form import kind_of
from followspot.yaml.node import Node

PROPERTIES: Mapping[str, tuple[str, ...]] = {
    "cameras": ("name", "kind", "model", "host"),
    "sensors": ("name", "kind", "host"),
    "targets": ("name",),
}
"""Properties that a condition may ask for, by set; every tag of the room is another one."""
_FORM = re.compile(r"([\w-]+)\s*(?:\[(.*)\])?", re.DOTALL)
_Owner = Camera | Sensor | Target


@dataclass(frozen=True)
class Condition:
    """A property or a tag must have one of these values."""

    key: str
    values: tuple[str, ...]

    def __str__(self) -> str:
        return f"{self.key}={'|'.join(self.values)}"


@dataclass(frozen=True)
class Selector:
    """A set of the room, or a tag as it is written, narrowed by conditions that all must hold."""

    set: str
    conditions: tuple[Condition, ...]
    place: Place

    @property
    def readable(self) -> bool:
        """False if the selector could not be read, so that its members are not known."""
        return bool(self.set)

    @property
    def text(self) -> str:
        """The selector in its written form."""
        return f"{self.set}[{', '.join(map(str, self.conditions))}]" if self.conditions else self.set

    def select(self, room: Room) -> tuple[Member, ...]:
        """The members that fit, in the order of the room; none for a tag that the room lacks."""
        if self.set in SETS:
            owners = room.members(self.set).values()
            return tuple(Member(self.set, o.name) for o in owners if _fits(o, self.conditions))
        tag = tag_named(self.set, room)
        of_value = tuple(c for c in self.conditions if c.key in ("name", tag))
        carriers = tuple(c for c in self.conditions if c not in of_value)
        values = dict.fromkeys(
            value for o in room.carriers if _fits(o, carriers) for value in o.tags.get(tag, ())
        )
        return tuple(Member(tag, v) for v in values if all(v in c.values for c in of_value))

    def unknown(self, room: Room) -> Mistake | None:
        """The mistake of a selector whose set, or the key of a condition, the room does not know."""
        tags = room.tags
        if self.set not in SETS and not tag_named(self.set, room):
            known = [*SETS, *(f"{tag}s" for tag in tags)]
            text = f'the room "{room.name}" has no {self.set}: no camera and no sensor carries such a tag'
            return Mistake(self.place, text, did_you_mean(self.set, known, "sets"))
        known = [*PROPERTIES.get(self.set, PROPERTIES["cameras"]), *tags]
        if self.set == "targets":
            known += [tag for target in room.targets.values() for tag in target.tags]
        strange = next((c.key for c in self.conditions if c.key not in known), None)
        if strange is None:
            return None
        text = f'{self.set} of the room "{room.name}" have no property and no tag "{strange}"'
        return Mistake(self.place, text, did_you_mean(strange, known, "properties and tags"))

    def choices(self, room: Room) -> str:
        """The possible values of the conditions, as text, for a selector that selects nothing."""
        owners = room.members(self.set).values() if self.set in SETS else room.carriers
        known = {c.key: dict.fromkeys(v for o in owners for v in _values(o, c.key)) for c in self.conditions}
        unfit = [c.key for c in self.conditions if not known[c.key].keys() & set(c.values)]
        if not unfit:
            return "each condition fits something, and nothing fits all of them"
        return "; ".join(
            f"{key} is one of: {', '.join(known[key]) or 'nothing'}" for key in dict.fromkeys(unfit)
        )


def read_selector(node: Node, mistakes: list[Mistake], key: str = "each") -> Selector:
    """Read the value of `key`; of one that cannot be read a mistake is noted, see `Selector.readable`."""
    found = _FORM.fullmatch(node.value.strip()) if isinstance(node.value, str) else None
    if found is None:
        text = f"{key} cannot be {kind_of(node)}"
        remedy = 'write cameras, sensors, targets or a tag, or "cameras[kind=color]"'
        remedy = 'write for example "cameras[kind=color]"' if key == "cameras" else remedy
        mistakes.append(Mistake(node.place, text, remedy))
        return Selector("", (), node.place)
    conditions = []
    for part in filter(str.strip, (found[2] or "").split(",")):
        key, sign, value = (piece.strip() for piece in part.partition("="))
        if sign and key:
            conditions.append(Condition(key, tuple(choice.strip() for choice in value.split("|"))))
        else:
            mistakes.append(Mistake(node.place, f'"{part.strip()}" is no condition', "write PROPERTY=VALUE"))
            return Selector("", (), node.place)
    plural = next((name for name, noun in SETS.items() if found[1] == noun), found[1])
    return Selector(plural, tuple(conditions), node.place)


def intersection(first: Selector, second: Selector) -> Selector:
    """The selector of the members of both, placed at the first. Raises ValueError if their sets differ."""
    if first.set != second.set:
        raise ValueError(f"{first.set} and {second.set} are different sets")
    conditions = list(first.conditions)
    for condition in second.conditions:
        _narrow(conditions, condition)
    return replace(first, conditions=tuple(conditions))


def within(selector: Selector, member: Member) -> Selector:
    """The part of a selector that belongs to one member of a set or tag, for a sub-graph of that member.

    Of the member's own set it is the member alone; of a tag, the cameras, sensors and tags that carry the
    value. Other sets stay whole: targets, for example, move from zone to zone.
    """
    if selector.set == member.set:
        condition = Condition("name", (member.name,))
    elif member.set not in SETS and selector.set != "targets":
        condition = Condition(member.set, (member.name,))
    else:
        return selector
    return intersection(selector, Selector(selector.set, (condition,), selector.place))


def related(room: Room, member: Member, other_set: str) -> tuple[Member, ...] | None:
    """The members of another set that are wired to this one; None if all of them are.

    A member of a tag belongs to the members that carry its value, unless none of that set carries the tag.
    """
    if member.set == other_set:
        return (member,)
    if (member.set in SETS) == (other_set in SETS):
        return None
    group, tag = (member.set, other_set) if member.set in SETS else (other_set, member.set)
    carried = room.carried.get((group, tag))
    if carried is None:
        return None
    if group == other_set:
        return carried.get(member.name, ())
    values = room.members(group)[member.name].tags.get(tag, ())
    return tuple(Member(tag, value) for value in values)


def ranks(room: Room) -> dict[Member, int]:
    """The order of all members: cameras, sensors, targets, then the values of each tag."""
    members = [Member(name, owner) for name in SETS for owner in room.members(name)]
    members += [Member(tag, value) for tag, values in room.tags.items() for value in values]
    return {member: rank for rank, member in enumerate(members)}


def _narrow(conditions: list[Condition], condition: Condition) -> None:
    """Add a condition to those that hold.

    Of a key that can have one value only, the condition that is there keeps the values that both allow, if
    there are any; else both stand, and select nothing.
    """
    for number, present in enumerate(conditions):
        both = tuple(value for value in present.values if value in condition.values)
        if present.key == condition.key and both and present.key in _SINGLE:
            conditions[number] = Condition(present.key, both)
            return
    if condition not in conditions:
        conditions.append(condition)


_SINGLE = frozenset(key for keys in PROPERTIES.values() for key in keys)
"""Keys that have one value; a camera may carry several values of a tag, and conditions on it stay apart."""


def _fits(owner: _Owner, conditions: Iterable[Condition]) -> bool:
    return all(any(value in c.values for value in _values(owner, c.key)) for c in conditions)


def _values(owner: _Owner, key: str) -> tuple[str, ...]:
    """The values of a tag or a property, none if it has neither."""
    if key in owner.tags:
        return owner.tags[key]
    return (getattr(owner, key),) if key in _SINGLE and hasattr(owner, key) else ()


def tag_named(word: str, room: Room) -> str:
    """The tag that a word names in the singular or plural; "" if the room has none."""
    return word if word in room.tags else next((tag for tag in room.tags if word in _plurals(tag)), "")


def _plurals(tag: str) -> tuple[str, ...]:
    return (f"{tag[:-1]}ies" if tag.endswith("y") else f"{tag}s", f"{tag}es")
