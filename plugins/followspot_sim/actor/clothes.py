"""The clothes of actors: the colour of every face of the surface; front and back differ."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from followspot import Array
from followspot_sim.actor.body import ARM, FOOT, HAIR, HAND, LEG, NECK, SKULL, TORSO, Body, hairline

Colour = tuple[int, int, int]
"""RGB as a display shows it."""


HEM = 0.88
"""Height between shirt and trousers in the rest pose, m."""


@dataclass(frozen=True)
class Outfit:
    """Clothes, skin and hair of one person.

    shirt: cut of the garment, a name of CUTS; cloth, second: its two colours; sleeves: how far they reach
    down, as a share of the arm; trousers, shoes, skin, hair: colours.
    """

    shirt: str
    cloth: Colour
    second: Colour
    sleeves: float
    trousers: Colour
    shoes: Colour
    skin: Colour
    hair: Colour


def paint(body: Body, wears: Outfit, rng: np.random.Generator) -> Array:
    """Colour of each face as a white light shows it, (F, 3) BGR, 0 to 255."""
    centre, region = body.mesh.centre(), body.region
    color = np.empty((len(region), 3))
    for name, dye in DYES.items():
        color[region == name] = dye(centre[region == name], wears)
    below = (region == TORSO) & (centre[:, 2] < HEM)
    color[below] = wears.trousers
    grain = rng.normal(1.0, 0.03, (len(region), 1))
    return np.asarray((color * grain)[:, ::-1].clip(0, 255))


def _plain(centre: Array, colour: Colour) -> Array:
    return np.tile(np.array(colour, float), (len(centre), 1))


def _chosen(centre: Array, first: Colour, *layers: tuple[Array, Colour]) -> Array:
    """The first colour, overlaid with others by their masks."""
    color = _plain(centre, first)
    for mask, other in layers:
        color[mask] = other
    return color


def _face(centre: Array, wears: Outfit) -> Array:
    """Skin with eyes, brows and a mouth in front; hair on the skull."""
    x, y, z = centre.T
    front, aside = x > 0.09, np.abs(y)
    eyes = front & (np.abs(aside - 0.031) < 0.011) & (np.abs(z - 1.632) < 0.007)
    brows = front & (np.abs(aside - 0.032) < 0.016) & (np.abs(z - 1.653) < 0.006)
    mouth = front & (aside < 0.022) & (np.abs(z - 1.570) < 0.007)
    return _chosen(
        centre,
        wears.skin,
        (z > hairline(x) - 0.01, wears.hair),
        (brows, _darker(wears.skin, 0.5)),
        (eyes, _darker(wears.skin, 0.4)),
        (mouth, _darker(wears.skin, 0.75, 0.5)),
    )


def _darker(colour: Colour, share: float, green_and_blue: float | None = None) -> Colour:
    red, *others = colour
    other = share if green_and_blue is None else green_and_blue
    return int(share * red), int(other * others[0]), int(other * others[1])


def _strands(centre: Array, colour: Colour) -> Array:
    """Hair, lighter and darker in strands that run down."""
    around = np.arctan2(centre[:, 1], centre[:, 0] - 0.04)
    return np.asarray(np.array(colour, float) * (1 + 0.14 * np.sin(19 * around))[:, None])


def _arm(centre: Array, wears: Outfit) -> Array:
    z = centre[:, 2]
    bare = z < 1.43 - wears.sleeves * 0.58
    sleeve = _plain(centre, wears.cloth)
    if wears.shirt in ("stripes", "plaid"):
        sleeve = CUTS[wears.shirt](centre - [0, HAND, 0], wears)
    sleeve[bare] = wears.skin
    return sleeve


def _shoe(centre: Array, colour: Colour) -> Array:
    return _chosen(centre, colour, (centre[:, 2] < 0.02, (190, 188, 180)))


def _print(centre: Array, wears: Outfit) -> Array:
    """A plain shirt with a picture on the chest."""
    x, y, z = centre.T
    out = np.hypot(y, z - 1.27)
    front = x > 0
    third = (225, 222, 210)
    return _chosen(
        centre,
        wears.cloth,
        (front & (out < 0.10), wears.second),
        (front & (out < 0.055), third),
        (front & (out < 0.10) & (np.abs(z - 1.27) < 0.018), wears.cloth),
    )


def _jacket(centre: Array, wears: Outfit) -> Array:
    """An open jacket: the shirt shows in front, wider below."""
    x, y, z = centre.T
    gap = np.interp(z, [0.9, 1.40, 1.5], [0.075, 0.05, 0.06])
    inside = (x > 0) & (np.abs(y) < gap)
    seam = (x > 0) & (np.abs(np.abs(y) - gap) < 0.012)
    return _chosen(centre, wears.cloth, (inside, wears.second), (seam, _darker(wears.cloth, 0.45)))


def _buttons(centre: Array, wears: Outfit) -> Array:
    """A shirt with a row of buttons, a collar and a pocket in front."""
    x, y, z = centre.T
    front = x > 0
    row = front & (np.abs(y) < 0.022)
    pocket = front & (np.abs(y - 0.09) < 0.045) & (np.abs(z - 1.29) < 0.05)
    collar = z > 1.46
    buttons = row & (np.mod(z, 0.09) < 0.028)
    darker = _darker(wears.cloth, 0.6)
    return _chosen(
        centre, wears.cloth, (collar, wears.second), (row, wears.second), (pocket, darker), (buttons, darker)
    )


def _halves(centre: Array, wears: Outfit) -> Array:
    """One colour in front, another behind."""
    return _chosen(centre, wears.cloth, (centre[:, 0] < 0, wears.second))


def _stripes(centre: Array, wears: Outfit) -> Array:
    """Level stripes, alike on all sides."""
    return _chosen(centre, wears.cloth, (np.mod(centre[:, 2], 0.10) < 0.045, wears.second))


def _plaid(centre: Array, wears: Outfit) -> Array:
    """Squares, alike on all sides."""
    level, upright = np.mod(centre[:, 2], 0.10) < 0.05, np.mod(centre[:, 1], 0.09) < 0.045
    rows = _chosen(centre, wears.cloth, (level, wears.second))
    return (rows + _chosen(centre, wears.cloth, (upright, wears.second))) / 2


CUTS: dict[str, Callable[[Array, Outfit], Array]] = {
    "print": _print,
    "jacket": _jacket,
    "buttons": _buttons,
    "halves": _halves,
    "stripes": _stripes,
    "plaid": _plaid,
}
"""Garments by name; the last two look alike from all sides."""

DYES: dict[int, Callable[[Array, Outfit], Array]] = {
    TORSO: lambda centre, wears: CUTS[wears.shirt](centre, wears),
    NECK: lambda centre, wears: _plain(centre, wears.skin),
    SKULL: _face,
    HAIR: lambda centre, wears: _strands(centre, wears.hair),
    ARM: _arm,
    LEG: lambda centre, wears: _plain(centre, wears.trousers),
    FOOT: lambda centre, wears: _shoe(centre, wears.shoes),
}
"""Colour of face centres (N, 3) in the rest pose, by region."""
