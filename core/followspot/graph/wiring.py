"""Edges fan out over instances: which instances of a sender feed an instance."""

from __future__ import annotations

from collections.abc import Collection, Iterator, Mapping, Sequence

from followspot.errors import Mistake, did_you_mean
from followspot.graph.declaration import Feed, InputDeclaration
from followspot.graph.instances import ANY, Groups, Instance, Wire
from followspot.graph.selector import ranks, related
from followspot.room import Member, Room

_MOST_NAMED = 6
"""Most members that a mistake names."""


class InstanceWiring:
    """Connects the instances of a graph."""

    def __init__(
        self, groups: Groups, left_out: Collection[str], room: Room, mistakes: list[Mistake]
    ) -> None:
        """left_out: optional stages and sub-graphs without instances; mistakes: receives mistakes."""
        self._groups, self._left_out, self._room, self._mistakes = groups, left_out, room, mistakes
        self._rank = ranks(room)
        self._around: dict[str, tuple[Member, ...]] = {}
        self._unserved: dict[tuple[str, Feed], list[Member]] = {}

    def into(self, target: Instance) -> Iterator[Wire]:
        """All wires to an instance, input by input."""
        for entry in target.declared.inputs:
            yield from self._wires(target, entry)

    def unserved(self) -> Iterator[Mistake]:
        """A mistake for each feed whose sender does not serve the members of its reader."""
        for (stage, feed), members in self._unserved.items():
            listed = ", ".join(map(str, members[:_MOST_NAMED]))
            listed += f" and {len(members) - _MOST_NAMED} more" if len(members) > _MOST_NAMED else ""
            text = f'stage "{stage}" serves {listed}, stage "{feed.stage}" does not'
            yield Mistake(feed.place, text, "give both the same each")

    def _wires(self, target: Instance, entry: InputDeclaration) -> list[Wire]:
        """All wires to one input, in the order of the room, for a join delivers in that order.

        Of several senders that fan out, such as sub-graphs of each camera, those feed the target that serve
        its member; a target for which none does is noted.
        """
        wires: list[Wire] = []
        strange: list[Feed] = []
        for feed in entry.feeds:
            sources = self._groups.get(feed.stage)
            if sources is not None:
                found = self._sources(target, feed, sources)
                wires += [Wire(source, feed, target, entry.port, entry.place) for source in found or ()]
                strange += [feed] if found is None else []
            elif feed.stage not in self._left_out:
                remedy = did_you_mean(feed.stage, self._groups, "stages")
                self._mistakes.append(Mistake(feed.place, f'there is no stage "{feed.stage}"', remedy))
        if strange and not wires:
            members = self._unserved.setdefault((target.declared.name, strange[0]), [])
            members += self._members(target)[:1]
        last = len(self._rank)
        return sorted(
            wires, key=lambda w: last if w.source.member is None else self._rank.get(w.source.member, last)
        )

    def _sources(
        self, target: Instance, feed: Feed, sources: Mapping[Member | None, Instance]
    ) -> Collection[Instance] | None:
        """The instances that feed a target: those of the same or a related member, else all of the stage.

        None if the stage serves other members only.
        """
        unknown = target.declared.each is not None and target.member is None
        if feed.only is not None and not feed.only.readable:
            return [next(iter(sources.values()))]
        if feed.only is not None and ANY not in sources and not unknown:
            chosen = feed.only.select(self._room)
            sources = {member: source for member, source in sources.items() if member in chosen}
            if not sources:
                text = f'no instance of stage "{feed.stage}" serves {feed.only.text}'
                self._mistakes.append(Mistake(feed.place, text, "change the selector, or leave it out"))
                return []
        first = next(iter(sources.values()))
        if unknown or (first.declared.each is not None and first.member is None):
            return [first]  # which member is not known because of a mistake
        found = self._of_own_members(target, sources)
        if target.declared.serves or first.declared.serves:
            found = [source for source in found if self._meet(target, source)]
        return found or None

    def _of_own_members(
        self, target: Instance, sources: Mapping[Member | None, Instance]
    ) -> Collection[Instance]:
        """The instances for the member that a target fans out to; all of them if either does not fan out."""
        first = next(iter(sources))
        if target.member is None or first is None:
            return sources.values()
        wanted = related(self._room, target.member, first.set)
        return sources.values() if wanted is None else [sources[m] for m in wanted if m in sources]

    def _meet(self, target: Instance, source: Instance) -> bool:
        """Whether all members that two instances belong to are related."""
        return all(
            (wanted := related(self._room, own, other.set)) is None or other in wanted
            for own in self._members(target)
            for other in self._members(source)
        )

    def _members(self, instance: Instance) -> Sequence[Member]:
        """The members that an instance belongs to: that of its own fan-out, and those of its sub-graphs."""
        around = self._around.get(instance.declared.name)
        if around is None:
            around = tuple(m for s in instance.declared.serves for m in s.select(self._room))
            self._around[instance.declared.name] = around
        return around if instance.member is None else (instance.member, *around)
