"""The difference between two plans of one run: stages that come, go or change, and their workers."""

from __future__ import annotations

from followspot.graph.plan import Plan


def differing_stages(old: Plan, new: Plan) -> set[str]:
    """The stages that only one of the plans has, or that differ between them."""
    before = {stage.name: stage for stage in old.stages}
    after = {stage.name: stage for stage in new.stages}
    return {name for name in before.keys() | after.keys() if before.get(name) != after.get(name)}


def workers_of(plan: Plan, stages: set[str]) -> set[str]:
    """The workers of those of the stages that the plan has."""
    return {stage.worker for stage in plan.stages if stage.name in stages}


def differing_workers(old: Plan, new: Plan) -> set[str]:
    """The workers, of either plan, with stages that differ or with an end of an edge that differs."""
    found: set[str] = set()
    for plan, other in ((old, new), (new, old)):
        found |= workers_of(plan, differing_stages(old, new))
        same = dict(other.numbered())
        for number, edge in plan.numbered():
            if number not in same or _connection(plan, number) != _connection(other, number):
                found |= {plan.worker_of(edge.from_stage), plan.worker_of(edge.to_stage)}
    return found


def only_worker(old: Plan, new: Plan) -> str | None:
    """The only worker in which the plans differ, new and former edges included; None if there are several.

    None also if it is a replay and other workers send to this worker: it could not know when it is at rest.
    """
    found = differing_workers(old, new)
    pairs = ((old, dict(new.numbered())), (new, dict(old.numbered())))
    for plan, other in pairs:
        if any(edge.kind != "reference" for number, edge in plan.numbered() if number not in other):
            return None
    same = {stage.name: stage.worker for stage in old.stages}
    if len(found) != 1 or any(same.get(stage.name, stage.worker) != stage.worker for stage in new.stages):
        return None
    worker = next(iter(found))
    return worker if new.live or not is_fed(new, worker) else None


def is_fed(plan: Plan, worker: str) -> bool:
    """True if stages of other workers send to this one, so that it cannot know when it has everything."""
    return any(
        plan.worker_of(edge.to_stage) == worker != plan.worker_of(edge.from_stage) for edge in plan.edges
    )


def _connection(plan: Plan, number: int) -> tuple[str, ...]:
    """The kind of an edge, and the hosts that it joins if it goes over the network."""
    edge = plan.edge(number)
    ends = (edge.from_stage, edge.to_stage) if edge.kind == "zenoh" else ()
    return (edge.kind, *map(plan.host_of_stage, ends))
