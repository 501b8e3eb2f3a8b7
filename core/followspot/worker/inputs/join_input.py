"""One parameter of `process` with the edges that feed it, and how a replaced stage keeps its edges."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass, replace

from followspot.ports.specs import InputSpec
from followspot.worker.inputs.input_queue import InputQueue
from followspot.worker.inputs.sampled_input import SampledInput


@dataclass(frozen=True)
class JoinInput:
    """One parameter of `process` and the edges that feed it: members of the join, or one sampled input.

    An optional input without an edge has neither; the stage gets None, or an empty tuple.
    """

    name: str
    joined: bool
    """Whether its argument is a tuple."""
    members: tuple[InputQueue, ...] = ()
    sampled: SampledInput | None = None

    @property
    def queues(self) -> tuple[InputQueue, ...]:
        """The queues of all edges that feed it."""
        return self.members if self.sampled is None else (*self.members, *self.sampled.queues)


def rearranged(inputs: Sequence[JoinInput], specs: Sequence[InputSpec]) -> Iterator[JoinInput]:
    """The inputs for a stage that declares these ports, perhaps in another order; an input that the former
    stage lacks has no edge. The only input of one stage is that of the other, whatever their names are.
    """
    known = {one.name: one for one in inputs}
    if len(specs) == len(inputs) == 1:
        known = {specs[0].name: inputs[0]}
    for spec in specs:
        yield replace(known.get(spec.name) or JoinInput(spec.name, joined=False), joined=spec.several)


def with_former_samples(inputs: Iterable[JoinInput], former: Iterable[JoinInput]) -> Iterator[JoinInput]:
    """The inputs; an input that samples the same edges as a former one of its name keeps its messages."""
    known = {one.name: one for one in former}
    for one in inputs:
        before = known.get(one.name)
        sampled = before.sampled if before is not None else None
        same = sampled is not None and one.sampled is not None and sampled.queues == one.sampled.queues
        yield replace(one, sampled=sampled) if same else one
