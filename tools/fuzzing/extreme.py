"""Well-formed and extreme messages: every number, text, shape and array is at or beyond its limits."""

from __future__ import annotations

import random
from typing import Any

import msgpack
import numpy as np

from followspot.graph.plan import EdgeCodec
from followspot.message_checks.sealing import seal
from followspot.messages import Array, InvalidMessage, Message, stamped
from followspot.transport.wire import ALIGN, MAX_HEAD, PREFIX, VERSION, pack_head, unpack_head
from followspot.transport.zenoh.codec import pack_as
from fuzzing.mutation import NASTY_FLOATS
from fuzzing.wire import sample

_POWERS = (7, 8, 15, 16, 31, 32, 52, 53, 61, 62, 63, 64)
_TEXTS = ("", "\0", "a" * 1000, "a" * 1001, "a" * 60_000, "../../etc", "\u202e", "\n\x1b[2J", "𝔘" * 300)
_CODECS: tuple[EdgeCodec, ...] = ("raw", "raw", "lossless", "jpeg")


def extreme_integer(rng: random.Random, least: int = -(1 << 63), most: int = (1 << 64) - 1) -> int:
    """Small, or within two of a power of two, of either sign."""
    if rng.random() < 0.3:
        found = rng.randrange(-3, 300)
    else:
        found = (1 << rng.choice(_POWERS)) + rng.randrange(-2, 3)
        found = -found if rng.random() < 0.4 else found
    return min(max(found, least), most)


def extreme_float(rng: random.Random) -> float:
    """Not a number, without end, huge, tiny, or an integer too large for its digits."""
    return rng.choice((*NASTY_FLOATS, 0.5, 2.0**53 + 2, 1e18, -1e-18))


def extreme_text(rng: random.Random) -> str:
    """Empty, long, or of letters that a terminal or a path minds."""
    return rng.choice(_TEXTS)


def extreme_array(rng: random.Random, like: Array) -> Array:
    """An array of the same shape and dtype: some of its values, or all, at the ends of their range."""
    if like.dtype.kind in "fc":
        ends = np.array([v for v in NASTY_FLOATS if like.dtype.itemsize > 4 or not 1e38 < abs(v) < np.inf])
    elif like.dtype.kind == "b":
        ends = np.array([True, False])
    else:
        limits = np.iinfo(like.dtype)
        ends = np.array([limits.min, limits.max, 0], like.dtype)
    numbers = np.random.default_rng(rng.randrange(1 << 30))
    chosen = numbers.random(like.shape) < rng.choice((0.02, 0.5, 1.0))
    return np.where(chosen, numbers.choice(ends, like.shape), like).astype(like.dtype)


def extreme_message(kind: type[Message], rng: random.Random) -> Message:
    """A message that keeps its contract, with extreme fields; its header is that of a sample."""
    like = sample(kind, rng, rng.choice((1, 2, 6, 60)))
    scalars: dict[Any, Any] = {str: extreme_text, float: extreme_float, bool: lambda r: r.random() < 0.5}
    scalars[int] = lambda r: extreme_integer(r, most=(1 << 63) - 1)
    values: dict[str, Any] = {c.name: extreme_array(rng, getattr(like, c.name)) for c in kind.columns}
    for name, of in kind.scalars:
        words = tuple(extreme_text(rng) for _ in range(rng.randrange(3)))
        values[name] = scalars[of](rng) if of in scalars else words
    try:
        return stamped(seal(kind(**values)), like.header)
    except InvalidMessage:  # its texts are too long together
        return extreme_message(kind, rng)


def extreme_token(kind: type[Message], rng: random.Random) -> bytes:
    """A message or a watermark as it travels, with an extreme header, shapes that lie, or both."""
    if rng.random() < 0.1:
        return pack_head((None, extreme_integer(rng)))
    message = extreme_message(kind, rng)
    packed = pack_as(message, rng.choice(_CODECS))
    fields, start = unpack_head(packed)
    for place in (2, 3, 4):
        if rng.random() < 0.4:
            fields[place] = extreme_integer(rng)
    if rng.random() < 0.2:
        fields[1] = extreme_text(rng)
    if rng.random() < 0.2 and fields[6]:
        column = rng.choice(fields[6])
        column[2] = [abs(extreme_integer(rng)) if rng.random() < 0.5 else size for size in column[2]]
    if rng.random() < 0.2 and fields[5]:
        fields[5][rng.choice(list(fields[5]))] = rng.choice((extreme_integer, extreme_float, extreme_text))(
            rng
        )
    return framed(fields, packed[:2], packed[start:])


def framed(fields: list[Any], start: bytes, body: bytes) -> bytes:
    """A token with this head, or one of a size that no head has. start: version and way of coding."""
    head: bytes = msgpack.packb(fields)[: MAX_HEAD + ALIGN - 1]
    assert start[0] == VERSION
    size = PREFIX.size + len(head)
    return start + len(head).to_bytes(2, "little") + head + bytes(-size % ALIGN) + body
