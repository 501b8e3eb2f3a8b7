"""Which topic of a log file has the camera's pictures."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path

from followspot.errors import InputError, did_you_mean


def chosen_topic(path: Path, types: Mapping[str, str], known: tuple[str, ...], wanted: str) -> str:
    """The topic with pictures: the one that is wanted, or for "" the only one.

    types: topic -> type of its messages; known: types that are pictures. Raises InputError.
    """
    pictures = sorted(topic for topic, kind in types.items() if kind in known)
    if wanted in pictures:
        return wanted
    if wanted in types:
        text = f"topic: {wanted} in {path} has messages of type {types[wanted] or 'unknown'}"
        raise InputError.of(text, f"pictures are {', '.join(known)}")
    if wanted:
        text = f'topic: {path} has no topic "{wanted}"'
        raise InputError.of(text, did_you_mean(wanted, pictures, "topics with pictures"))
    if len(pictures) != 1:
        text = f"{path} has {len(pictures)} topics with pictures"
        listing = f"topics: {', '.join(sorted(types)[:12]) or 'none'}"
        raise InputError.of(text, f"say which: {', '.join(pictures[:12])}" if pictures else listing)
    return pictures[0]
