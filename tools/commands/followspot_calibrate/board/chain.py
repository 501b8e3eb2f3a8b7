"""From pairs of cameras with shared views to the poses of all: the strongest spanning tree."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from itertools import combinations

from followspot.errors import FollowspotError
from followspot_calibrate.board.poses import STILL, BoardPose, Relation, relate
from followspot_calibrate.similarity import Similarity

LEAST_MOMENTS = 3
"""Smallest number of agreeing views that links a pair of cameras."""
CONTRADICTING = 10
"""Shared views from which it is no want of them that too few agree."""

Seen = Mapping[int, Sequence[BoardPose]]
"""Moment -> poses of the board in one camera."""
Pairs = Mapping[tuple[int, int], Relation]


def relations(seen: Sequence[Seen]) -> dict[tuple[int, int], Relation]:
    """Every pair of cameras, by number, that saw the board at the same moment."""
    found = {}
    for a, b in combinations(range(len(seen)), 2):
        both = sorted(seen[a].keys() & seen[b].keys())
        relation = relate([seen[a][moment] for moment in both], [seen[b][moment] for moment in both])
        if relation is not None:
            found[a, b] = relation
    return found


def chained(names: Sequence[str], pairs: Pairs) -> list[Similarity]:
    """Poses from the first camera to each, over the pairs that agree on most moments (Prim 1957).

    Raises FollowspotError if a camera is linked to no other; it names the best pair to mend.
    """
    poses = {0: STILL}
    while len(poses) < len(names):
        best, at = None, (0, 0)
        for (a, b), relation in pairs.items():
            if ((a in poses) != (b in poses)) and (best is None or relation.moments > best.moments):
                best, at = relation, (a, b)
        if best is None or best.moments < LEAST_MOMENTS:
            raise FollowspotError(_unlinked(names, sorted(poses), pairs))
        a, b = at
        if a in poses:
            poses[b] = best.pose.after(poses[a])
        else:
            poses[a] = best.pose.inverse.after(poses[b])
    return [poses[number] for number in range(len(names))]


def _unlinked(names: Sequence[str], linked: Sequence[int], pairs: Pairs) -> str:
    """Which camera is nearest to being linked, and what to do."""
    others = [number for number in range(len(names)) if number not in linked]
    between = {
        (a, b): (found.moments, found.shared) if (found := pairs.get((min(a, b), max(a, b)))) else (0, 0)
        for a in linked
        for b in others
    }
    a, b = max(between, key=lambda pair: between[pair])
    moments, shared = between[a, b]
    if shared >= CONTRADICTING:
        return (
            f"{names[a]}-{names[b]} agree on {moments} of the {shared} moments with the board in both, "
            f"{LEAST_MOMENTS} needed: one of them is out of step with the others, its picture is mirrored, "
            "or it has another lens than the room says"
        )
    return (
        f"{names[a]}-{names[b]} agree on {moments} moments with the board in both, "
        f"{LEAST_MOMENTS} needed: show the board to {names[b]} and another camera at once, in more places"
    )
