"""Order and cycles of stages."""

from __future__ import annotations

import heapq
from collections.abc import Collection, Iterable, Mapping, Sequence

Successors = Mapping[str, Sequence[str]]


def successors(names: Iterable[str], edges: Iterable[tuple[str, str]]) -> dict[str, list[str]]:
    """For each name, the targets of its edges, in the order of the edges and each once."""
    found: dict[str, dict[str, None]] = {name: {} for name in names}
    for start, end in edges:
        found[start][end] = None
    return {name: list(ends) for name, ends in found.items()}


def components(graph: Successors) -> dict[str, int]:
    """For each name the number of its strongly connected component (Tarjan 1972, without recursion)."""
    index: dict[str, int] = {}
    low: dict[str, int] = {}
    stack: list[str] = []
    number: dict[str, int] = {}
    for root in graph:
        if root in index:
            continue
        work = [(root, iter(graph[root]))]
        index[root] = low[root] = len(index)
        stack.append(root)
        while work:
            name, ends = work[-1]
            end = next(ends, None)
            if end is None:
                work.pop()
                if work:
                    low[work[-1][0]] = min(low[work[-1][0]], low[name])
                if low[name] == index[name]:
                    while name not in number:
                        number[stack.pop()] = index[name]
            elif end not in index:
                index[end] = low[end] = len(index)
                stack.append(end)
                work.append((end, iter(graph[end])))
            elif end not in number:
                low[name] = min(low[name], index[end])
    return number


def cyclic(edges: Collection[tuple[str, str]]) -> set[tuple[str, str]]:
    """The edges that are part of a cycle."""
    component = components(successors(dict.fromkeys(name for ends in edges for name in ends), edges))
    return {(start, end) for start, end in edges if component[start] == component[end]}


def cycles(graph: Successors) -> list[list[str]]:
    """One shortest cycle of each component that has one, from its first member on, which ends it too."""
    component = components(graph)
    found = []
    seen: set[int] = set()
    for name in graph:
        if component[name] in seen:
            continue
        path = _path(graph, name, name, component)
        if path:
            seen.add(component[name])
            found.append(path)
    return found


def cycle_through(graph: Successors, start: str, end: str, component: Mapping[str, int]) -> list[str]:
    """The shortest cycle that begins with the edge from `start` to `end`; both are in one component."""
    return [start, end] if start == end else [start, *_path(graph, end, start, component)]


def _path(graph: Successors, start: str, goal: str, component: Mapping[str, int]) -> list[str]:
    """Shortest path of at least one edge within the component of `start`; empty if there is none."""
    came: dict[str, str] = {}
    queue = [start]
    for name in queue:
        for end in graph[name]:
            if end == goal:
                path = [goal, name]
                while path[-1] != start:
                    path.append(came[path[-1]])
                return path[::-1]
            if end not in came and component[end] == component[start]:
                came[end] = name
                queue.append(end)
    return []


def topological(graph: Successors) -> list[str]:
    """Names in topological order; names without an order between them keep the order of the mapping.

    Raises ValueError if there is a cycle.
    """
    rank = {name: number for number, name in enumerate(graph)}
    waiting = dict.fromkeys(graph, 0)
    for ends in graph.values():
        for end in ends:
            waiting[end] += 1
    free = [rank[name] for name, count in waiting.items() if count == 0]
    names = list(graph)
    order = []
    while free:
        name = names[heapq.heappop(free)]
        order.append(name)
        for end in graph[name]:
            waiting[end] -= 1
            if waiting[end] == 0:
                heapq.heappush(free, rank[end])
    if len(order) < len(names):
        raise ValueError("the graph has a cycle")
    return order
