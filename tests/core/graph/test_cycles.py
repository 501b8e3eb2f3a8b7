"""Order and cycles, against what they are defined by."""

from __future__ import annotations

from itertools import pairwise

from hypothesis import given
from hypothesis import strategies as st

from followspot.graph.cycles import components, cycles, successors, topological

NAMES = "abcdefgh"
graphs = st.lists(st.tuples(st.sampled_from(NAMES), st.sampled_from(NAMES)), max_size=20)


def reachable(graph: dict[str, list[str]], start: str) -> set[str]:
    seen: set[str] = set()
    queue = list(graph[start])
    while queue:
        name = queue.pop()
        if name not in seen:
            seen.add(name)
            queue += graph[name]
    return seen


@given(graphs)
def test_names_share_a_component_when_each_reaches_the_other(edges: list[tuple[str, str]]) -> None:
    graph = successors(NAMES, edges)
    number = components(graph)
    reach = {name: reachable(graph, name) for name in NAMES}
    for a in NAMES:
        for b in NAMES:
            mutual = a == b or (b in reach[a] and a in reach[b])
            assert (number[a] == number[b]) == mutual


@given(graphs)
def test_every_cycle_that_is_named_is_one_and_none_is_missed(edges: list[tuple[str, str]]) -> None:
    graph = successors(NAMES, edges)
    found = cycles(graph)
    for cycle in found:
        assert cycle[0] == cycle[-1]
        assert all(end in graph[start] for start, end in pairwise(cycle))
        assert len(set(cycle)) == len(cycle) - 1
    assert bool(found) == any(name in reachable(graph, name) for name in NAMES)


@given(graphs)
def test_a_topological_order_leads_forward_and_keeps_the_order_of_what_is_free(
    edges: list[tuple[str, str]],
) -> None:
    forward = [(min(a, b), max(a, b)) for a, b in edges if a != b]
    backward = [(b, a) for a, b in forward]
    assert topological(successors(NAMES, forward)) == list(NAMES)
    order = topological(successors(NAMES, backward))
    assert all(order.index(start) < order.index(end) for start, end in backward)
