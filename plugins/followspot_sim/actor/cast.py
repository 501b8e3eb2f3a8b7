"""The actors: shape and clothes of each, drawn from a seed."""

from __future__ import annotations

from dataclasses import dataclass
from functools import lru_cache

import numpy as np

from followspot import Array
from followspot_sim.actor.body import Body, Build, body_of
from followspot_sim.actor.clothes import CUTS, Colour, Outfit, paint

CLOTH: tuple[tuple[Colour, Colour], ...] = (
    ((34, 140, 85), (232, 226, 214)),
    ((178, 52, 48), (38, 44, 92)),
    ((52, 112, 176), (226, 128, 44)),
    ((206, 168, 60), (70, 52, 84)),
    ((118, 70, 140), (214, 206, 196)),
    ((60, 64, 70), (196, 60, 92)),
)
"""Two colours of a garment; those of two actors differ."""
TROUSERS: tuple[Colour, ...] = ((46, 54, 82), (70, 66, 54), (44, 42, 44), (104, 92, 74), (58, 84, 108))
SKIN: tuple[Colour, ...] = ((214, 168, 140), (224, 182, 158), (188, 136, 106), (138, 94, 68), (98, 66, 50))
FAIR, DARK_HAIR = 2, 3
"""So many skins go with all colours of hair, the others with so many of them; both stand first."""
HAIR: tuple[Colour, ...] = (
    (46, 34, 28),
    (28, 26, 28),
    (150, 148, 142),
    (98, 62, 34),
    (150, 76, 36),
    (188, 150, 86),
)
SHOES: tuple[Colour, ...] = ((40, 34, 32), (210, 206, 198), (90, 60, 40))


@dataclass(frozen=True, eq=False)
class Actor:
    """One person: the body, and the colour of its faces, (F, 3) BGR."""

    body: Body
    color: Array


@lru_cache(maxsize=4)
def cast_of(seed: int, people: int) -> tuple[Actor, ...]:
    """The actors of a performance, in the order of their numbers."""
    rng = np.random.default_rng([seed, 4711])
    cuts = [str(name) for name in rng.permutation([*CUTS])]
    cloth = rng.permutation(len(CLOTH))
    return tuple(_actor(rng, cuts[k % len(cuts)], CLOTH[cloth[k % len(CLOTH)]]) for k in range(people))


def _actor(rng: np.random.Generator, cut: str, cloth: tuple[Colour, Colour]) -> Actor:
    woman = bool(rng.integers(2))
    build = Build(
        stature=float(np.clip(rng.normal(1.68 if woman else 1.79, 0.06), 1.55, 1.95)),
        girth=float(rng.uniform(0.9, 1.12) * (0.95 if woman else 1.02)),
        bust=float(rng.uniform(0.015, 0.035)) if woman else 0.0,
        hair=str(rng.choice(["bob", "long", "bun"])) if woman else "short",
    )
    skin = int(rng.integers(len(SKIN)))
    outfit = Outfit(
        shirt=cut,
        cloth=cloth[0],
        second=cloth[1],
        sleeves=float(rng.choice([0.45, 0.95])),
        trousers=TROUSERS[rng.integers(len(TROUSERS))],
        shoes=SHOES[rng.integers(len(SHOES))],
        skin=SKIN[skin],
        hair=HAIR[rng.integers(len(HAIR) if skin < FAIR else DARK_HAIR)],
    )
    body = body_of(build)
    return Actor(body, paint(body, outfit, rng))
