"""Promises about messages: every type of a stage can be packed and unpacked."""

from __future__ import annotations

from collections.abc import Iterator

from followspot.message_checks.sealing import seal
from followspot.messages import Header, InvalidMessage, Message, identical, stamped
from followspot.testing.samples import BLACK, Content, sample
from followspot.testing.trial import Trial
from followspot.transport.codec import pack, unpack

_HEADER = Header("conformance", 7, 1_000_000_000, 5)


def speaks_empty_messages_that_travel(trial: Trial) -> Iterator[str]:
    """A message without rows arrives bit for bit."""
    return _travels(trial, "empty")


def speaks_messages_that_travel(trial: Trial) -> Iterator[str]:
    """A message with rows arrives bit for bit."""
    return _travels(trial, "plausible")


def speaks_unknown_numbers_that_travel(trial: Trial) -> Iterator[str]:
    """NaN arrives as it was sent."""
    return _travels(trial, "unknown")


def refuses_messages_cut_short(trial: Trial) -> Iterator[str]:
    """Half a message is refused, never taken for a whole one."""
    for kind in _kinds(trial):
        packed = pack(_message(trial, kind, "plausible"))
        try:
            unpack(packed[: len(packed) - 1], kind)
        except InvalidMessage:
            continue
        yield f"a {kind.__name__} that was cut short is taken for a whole one"


def _travels(trial: Trial, content: Content) -> Iterator[str]:
    for kind in _kinds(trial):
        message = _message(trial, kind, content)
        arrived = unpack(pack(message), kind)
        if not (isinstance(arrived, Message) and identical(arrived, message)):
            yield f"{kind.__name__} does not survive the wire"


def _message(trial: Trial, kind: type[Message], content: Content) -> Message:
    return stamped(seal(sample(kind, content, trial.room, "cam0", BLACK)), _HEADER)


def _kinds(trial: Trial) -> list[type[Message]]:
    ports = trial.ports
    kinds = ({port.type for port in ports.inputs} | {port.type for port in ports.outputs}) - {Message}
    return sorted(kinds, key=lambda kind: kind.__name__)
