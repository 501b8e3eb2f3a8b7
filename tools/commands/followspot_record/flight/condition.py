"""Conditions over a port's messages and ledger, such as `track.tracks: count(state == tracked) < 4`."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import Any

import numpy as np

from followspot.errors import InputError, did_you_mean
from followspot.messages import Message
from followspot.room import Room
from followspot_record.flight.expression import COMPARISONS, Expression, Source, parse
from followspot_record.flight.figures import LEDGER, Figure, Kind, figures_of

OPTION = "--mark-when"
_OTHER_WORDS = {"drops": "dropped"}
_TRUTHS = {"any": np.any, "all": np.all}
_FIGURES: Mapping[str, Callable[..., Any]] = {
    "min": np.fmin.reduce,
    "max": np.fmax.reduce,
    "sum": np.sum,
    "mean": np.mean,
    "abs": np.abs,
}
_SIGNS = {"+": np.add, "-": np.subtract, "*": np.multiply, "/": np.divide}
_ORDER = {
    "<": np.less,
    "<=": np.less_equal,
    ">": np.greater,
    ">=": np.greater_equal,
    "==": np.equal,
    "!=": np.not_equal,
}


def split_condition(text: str) -> tuple[str, Source]:
    """The port that a condition names, and its expression. Raises InputError."""
    port, colon, _ = text.partition(":")
    if not colon or not port.strip():
        remedy = "write for example: track.tracks: count(state == tracked) < 4"
        raise InputError.of(f"{OPTION}: {text!r} names no port", remedy)
    return port.strip(), Source(OPTION, text, len(port) + 1)


class Condition:
    """A condition over the messages of one type. in_messages: whether it speaks of their fields."""

    def __init__(self, source: Source, kind: type[Message], room: Room) -> None:
        """Raises InputError with the place of what is wrong."""
        self.text = source.text.strip()
        self.in_messages = False
        self._source = source
        self._figures = figures_of(kind, room)
        self._root = parse(source)
        self._need(self._root, "truth")

    def holds(self, message: Message | None, losses: Mapping[str, int]) -> bool:
        """Whether it holds, of any row. losses: messages lost since the last check, by column.

        message: may be None for a condition that speaks of the ledger alone.
        """
        with np.errstate(all="ignore"):
            return bool(np.any(self._value(self._root, message, losses)))

    def _need(self, node: Expression, kind: Kind) -> None:
        """Raises InputError unless the node is of this kind."""
        found = self._kind(node)
        if found != kind:
            names = {"number": "a number", "truth": "a comparison", "word": "a name"}
            text = f"{names[kind]} belongs here, and this is {names[found]}"
            remedy = "compare it, for example with > 0" if kind == "truth" else "see `followspot echo --json`"
            raise self._source.mistake(node.token, text, remedy)

    def _kind(self, node: Expression) -> Kind:
        """The kind of a node whose parts fit. Raises InputError."""
        form = node.form
        if form in ("number", "text"):
            return "number" if form == "number" else "word"
        if form == "word":
            return self._known(node)
        if form == "call":
            return self._called(node)
        if form in COMPARISONS:
            return self._compared(node)
        kind: Kind = "truth" if form in ("and", "or", "not") else "number"
        for part in node.parts:
            self._need(part, kind)
        return kind

    def _known(self, node: Expression) -> Kind:
        name = _OTHER_WORDS.get(node.token.text, node.token.text)
        if name in self._figures:
            self.in_messages = True
            return self._figures[name].kind
        if name in LEDGER:
            return "number"
        known = {*self._figures, *LEDGER}
        raise self._source.mistake(
            node.token, f'there is no "{node.token.text}"', did_you_mean(name, known, "figures")
        )

    def _called(self, node: Expression) -> Kind:
        name = node.token.text
        if name in (*_TRUTHS, "count"):
            self._need(node.parts[0], "truth")
            return "number" if name == "count" else "truth"
        if name in _FIGURES:
            self._need(node.parts[0], "number")
            return "number"
        known = (*_TRUTHS, "count", *_FIGURES)
        raise self._source.mistake(
            node.token, f'there is no function "{name}"', did_you_mean(name, known, "functions")
        )

    def _compared(self, node: Expression) -> Kind:
        figure, word = self._word_compared(node)
        if figure is None:
            for part in node.parts:
                self._need(part, "number")
            return "truth"
        self.in_messages = True
        if node.form not in ("==", "!="):
            raise self._source.mistake(node.token, "names are equal or not", "write == or !=")
        if word.form not in ("word", "text"):
            raise self._source.mistake(word.token, "a name belongs here", "write for example 'blue'")
        if figure.words and _literal(word) not in figure.words:
            remedy = did_you_mean(_literal(word), figure.words, "names")
            raise self._source.mistake(word.token, f'there is no "{_literal(word)}"', remedy)
        return "truth"

    def _word_compared(self, node: Expression) -> tuple[Figure | None, Expression]:
        """The names of a figure in a comparison, and the value that it is compared with."""
        for part, other in (node.parts, node.parts[::-1]):
            figure = self._figures.get(part.token.text) if part.form == "word" else None
            if figure is not None and figure.kind == "word":
                return figure, other
        return None, node

    def _value(self, node: Expression, message: Message | None, losses: Mapping[str, int]) -> Any:
        form, token = node.form, node.token
        if form == "number":
            return float(token.text)
        if form == "word":
            name = _OTHER_WORDS.get(token.text, token.text)
            figure = self._figures.get(name)
            return losses[name] if figure is None or message is None else figure.of(message)
        if form in COMPARISONS:
            figure, word = self._word_compared(node)
            if figure is not None and message is not None:
                wanted = figure.words.index(_literal(word)) if figure.words else _literal(word)
                return _ORDER[form](figure.of(message), wanted)
        values = [self._value(part, message, losses) for part in node.parts]
        if form == "call":
            return _call(token.text, np.atleast_1d(values[0]))
        if form == "negative":
            return np.negative(values[0])
        if form == "not":
            return np.logical_not(values[0])
        if form in ("and", "or"):
            return (np.logical_and if form == "and" else np.logical_or)(*values)
        return _ORDER[form](*values) if form in _ORDER else _SIGNS[form](*values)


def _call(name: str, values: Any) -> Any:
    if name == "count":
        return np.count_nonzero(values)
    if name in _TRUTHS:
        return _TRUTHS[name](values)
    if name != "abs" and not len(values):
        return 0.0 if name == "sum" else np.nan
    return _FIGURES[name](values)


def _literal(node: Expression) -> str:
    return node.token.text.strip("'\"")
