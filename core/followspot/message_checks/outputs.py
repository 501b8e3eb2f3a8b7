"""Checks of the outputs of stages: declared message types, and capture times from sources only."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from typing import Any

from followspot.errors import FollowspotError
from followspot.message_checks.type_names import named_value
from followspot.messages import UNSTAMPED, Header, Message
from followspot.ports.specs import ONE_OUTPUT, OutputSpec

_MISSING = object()


class WrongOutput(FollowspotError):
    """The output of a stage differs from its signature; the text has the difference and the remedy."""


def untimed(header: Header) -> bool:
    """True if the stage did not call at() with the message of this header."""
    return header is UNSTAMPED or header.source != ""


def check_returned(declared: Sequence[OutputSpec], result: Any) -> None:
    """Check the result of `process` of a stage with inputs. Raises WrongOutput."""
    for message in _messages(declared, result, "returned"):
        if not untimed(message.header):
            raise WrongOutput(
                f"returned a {type(message).__name__} with a capture time of its own: only a source has one;"
                " return the message without at(), and it gets the time of the input that fired"
            )


def several(result: Any) -> Iterator[Any]:
    """An iterator over what a source, or a stage with several results, gives. Raises WrongOutput."""
    try:
        return iter(result)
    except TypeError:
        raise WrongOutput(
            f"returned {named_value(result)} instead of several messages: yield them, or return a list"
        ) from None


def check_yielded(declared: Sequence[OutputSpec], item: Any, *, live: bool) -> Header:
    """Check the result of a source; returns the header with the capture time, common to all its messages.

    If a live source leaves the time to the runtime, the header is UNSTAMPED. Raises WrongOutput.
    """
    headers = [message.header for message in _messages(declared, item, "yielded")]
    if not headers:
        raise WrongOutput("yielded nothing: leave the `yield` out where there is nothing to send")
    given = [header for header in headers if header is not UNSTAMPED]
    if not given and not live:
        raise WrongOutput("yielded a message without its capture time: write `yield at(time_ns, message)`")
    if len(given) > 1 and any(header[1:3] != given[0][1:3] for header in given):
        raise WrongOutput("yielded outputs of several times: give all of them the same time and number")
    return given[0] if given else UNSTAMPED


def check_one_of_several(declared: Sequence[OutputSpec], item: Any) -> Header:
    """Check one of several results; returns the header with its capture time, UNSTAMPED if it has none.

    Raises WrongOutput.
    """
    headers = [message.header for message in _messages(declared, item, "gave")]
    if not headers:
        raise WrongOutput("gave nothing among several outputs: leave it out")
    given = [header for header in headers if not untimed(header)]
    if any(header[1:3] != given[0][1:3] for header in given):
        raise WrongOutput("gave outputs of several times at once: give all of them the same time and number")
    return given[0] if given else UNSTAMPED


def _messages(declared: Sequence[OutputSpec], output: Any, did: str) -> Sequence[Message]:
    """The messages among the outputs, each of the declared type. Raises WrongOutput."""
    if len(declared) == 1 and declared[0].name == ONE_OUTPUT:
        return () if output is None else (_of_type(declared[0].type, output, did),)
    if not declared:
        raise WrongOutput(f"{did} {named_value(output)}, declared None: declare what `process` returns")
    found = []
    for port in declared:
        message = getattr(output, port.name, _MISSING)
        if message is _MISSING:
            names = ", ".join(f"`{each.name}`" for each in declared)
            raise WrongOutput(f"{did} {named_value(output)}, declared outputs {names}: name each of them")
        if message is not None:
            found.append(_of_type(port.type, message, f"{did} as `{port.name}`"))
    return found


def _of_type(kind: type[Message], message: Any, did: str) -> Message:
    if type(message) is not kind:
        raise WrongOutput(
            f"{did} {named_value(message)}, declared {kind.__name__}: the type must be exactly that"
        )
    return message
