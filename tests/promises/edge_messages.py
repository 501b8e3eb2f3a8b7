"""Real messages for what a model says, and what they say to a model."""

from __future__ import annotations

import numpy as np
from tests.promises.edge_model import Advance, Missing, Spoken, Word

from followspot.message_checks.sealing import seal
from followspot.messages import Array, Header, Message, column, stamped
from followspot.transport.token import Invalid, Token, Watermark

SMALL = 100
"""Bytes of an array that travels in the datagram."""


class Picture(Message):
    """Shows its number in every byte."""

    number: int
    pixels: Array = column("N", dtype="u1")


def picture(spoken: Spoken, size: int, pixels: Array | None = None) -> Picture:
    """The message, in an array of its own or in the one that is given."""
    if pixels is None:
        pixels = np.empty(size, np.uint8)
    pixels[:] = spoken.number % 251
    return stamped(seal(Picture(spoken.number, pixels)), header(spoken))


def header(spoken: Spoken) -> Header:
    return Header("camera/cam0", spoken.number, spoken.time)


def intact(message: Message) -> bool:
    """Whether it still shows its number."""
    assert isinstance(message, Picture)
    return bool((message.pixels == message.number % 251).all()) and message.number == message.header.seq


def word(token: Token) -> Word:
    """What a token says. Raises AssertionError if its content is damaged."""
    if isinstance(token, Watermark):
        return Advance(token.time)
    if isinstance(token, Invalid):
        return Missing(token.reason)
    assert intact(token), f"message {token.header.seq} is damaged"
    return Spoken(token.header.seq, token.header.time)
