"""The arguments of `followspot swap` and `followspot set`, and the places of mistakes in them."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import replace

from followspot.errors import Mistake, Place

_USES = ".uses"


def sets_parameter(word: str) -> bool:
    """True for STAGE.KEY=VALUE, False for STAGE=USES."""
    return "." in word.partition("=")[0]


def as_set_option(word: str) -> str:
    """The word as `--set` takes it: STAGE=USES is short for STAGE.uses=USES."""
    stage, sign, uses = word.partition("=")
    return f"{stage}{_USES}={uses}" if sign and not sets_parameter(word) else word


def as_typed(mistakes: Iterable[Mistake], words: Sequence[str]) -> list[Mistake]:
    """The mistakes with their places in the words that the user typed, not in the full forms of the words."""
    typed = {as_set_option(word): word for word in words}
    return [replace(mistake, place=_typed(mistake.place, typed)) for mistake in mistakes]


def _typed(place: Place | None, typed: Mapping[str, str]) -> Place | None:
    """The place as it was typed. typed: the words by their long form."""
    if place is None:
        return None
    outer = _typed(place.outer, typed)
    word = typed.get(place.written)
    if word is None:
        return replace(place, outer=outer)
    command = "set" if sets_parameter(word) else "swap"
    at = replace(place, file=command, written=word, outer=outer)
    stage = len(word.partition("=")[0])
    if word == place.written or place.column <= stage:
        return at
    if place.column > stage + len(_USES):
        return replace(at, column=place.column - len(_USES))
    return replace(at, column=1, width=max(1, stage))
