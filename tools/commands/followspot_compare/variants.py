"""Variants: a graph file with overrides each."""

from __future__ import annotations

import re
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

from followspot.errors import InputError, Mistake, Place

_NEXT = re.compile(r",(?=[\w-]+(?:\.[\w-]+)+=)")
"""A comma between two overrides; others belong to a value."""
_NAME = re.compile(r"\w[\w ,+.=%-]{0,59}")
"""Names become names of folders, so they hold no slash and do not begin with a dot."""


@dataclass(frozen=True)
class Variant:
    """A variant to compare. overrides: STAGE.KEY=VALUE, applied after those for all variants."""

    name: str
    graph: str
    overrides: tuple[str, ...] = ()


def read_variants(graphs: Sequence[str], options: Sequence[str]) -> tuple[Variant, ...]:
    """The graphs as they are written, named like their files; then the first one changed by each option.

    options: NAME:STAGE.KEY=VALUE[,STAGE.KEY=VALUE]... Raises InputError with every mistake.
    """
    mistakes: list[Mistake] = []
    variants = [Variant(Path(graph).stem, graph) for graph in graphs]
    variants += [_variant(graphs[0], option, mistakes) for option in options]
    names = [variant.name for variant in variants]
    for name in dict.fromkeys(n for n in names if names.count(n) > 1):
        remedy = "rename a file, or give a --variant another name"
        mistakes.append(Mistake(None, f'{names.count(name)} variants are named "{name}"', remedy))
    if mistakes:
        raise InputError(mistakes)
    return tuple(variants)


def _variant(graph: str, option: str, mistakes: list[Mistake]) -> Variant:
    name, colon, changes = option.partition(":")
    place = Place("--variant", 1, 1, max(1, len(name)), option or " ")
    if not colon or not changes:
        example = "NAME:STAGE.KEY=VALUE, for example mean:fuse.uses=balls.mean"
        mistakes.append(Mistake(place, f'"{option}" is no variant', f"write {example}"))
    elif not _NAME.fullmatch(name):
        remedy = "letters, digits, blanks and _ , + - . = %, at most 60"
        mistakes.append(Mistake(place, f'a variant cannot be named "{name}"', remedy))
    return Variant(name, graph, tuple(_NEXT.split(changes)))
