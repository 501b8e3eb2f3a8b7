"""The signature of `process` is the contract; a bad one is refused with what to write."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass
from typing import Any

import pytest

from followspot import Joined, Lagged, Latest, Message, Nearest, Outputs, Source, Stage, Window
from followspot.ports.signature import SignatureError, check_init, gives_always, ports
from followspot.ports.specs import InputSpec, OutputSpec, Ports, accepts


class Wheat(Message):
    grams: float


class Rye(Wheat):
    pass


class Bread(Message):
    loaves: int


@dataclass(frozen=True)
class Baked:
    bread: Bread
    crumbs: Wheat | None


@dataclass(frozen=True)
class Odd:
    bread: Bread
    price: float


@dataclass(frozen=True)
class AnyField:
    bread: Bread
    rest: Message | None


def stage(process: Callable[..., Any]) -> type[Stage]:
    return type("Baker", (Stage,), {"process": process})


def test_kinds_and_types_of_inputs_are_read() -> None:
    def process(
        self: Any,
        flour: Wheat,
        sacks: Joined[Wheat],
        order: Latest[Bread],
        guest: Nearest[Bread],
        orders: Window[Bread] = (),
        salt: Message | None = None,
    ) -> Bread: ...

    assert ports(stage(process)) == Ports(
        (
            InputSpec("flour", Wheat, "plain", True),
            InputSpec("sacks", Wheat, "joined", True),
            InputSpec("order", Bread, "latest", True),
            InputSpec("guest", Bread, "nearest", True),
            InputSpec("orders", Bread, "window", False),
            InputSpec("salt", Message, "plain", False),
        ),
        (OutputSpec("out", Bread),),
        False,
    )


def test_fields_of_a_dataclass_are_several_outputs() -> None:
    def process(self: Any, flour: Wheat) -> Baked | None: ...

    assert ports(stage(process)).outputs == (OutputSpec("bread", Bread), OutputSpec("crumbs", Wheat))


def test_a_generator_of_messages_is_a_source() -> None:
    def one(self: Any) -> Source[Bread]: ...

    def several(self: Any) -> Iterator[Baked]: ...

    assert ports(stage(one)) == Ports((), (OutputSpec("out", Bread),), True)
    assert [port.name for port in ports(stage(several)).outputs] == ["bread", "crumbs"]


def test_a_stage_that_returns_none_is_a_sink() -> None:
    def process(self: Any, bread: Bread) -> None: ...

    assert ports(stage(process)).outputs == ()


def test_an_output_may_say_nothing() -> None:
    def process(self: Any, flour: Wheat) -> Bread | None: ...

    assert ports(stage(process)).outputs == (OutputSpec("out", Bread),)


def test_an_input_takes_its_type_and_what_derives_from_it() -> None:
    assert accepts(Wheat, Rye)
    assert accepts(Message, Bread)
    assert not accepts(Rye, Wheat)
    assert not accepts(Bread, Wheat)


def no_types(self: Any, flour) -> Bread: ...  # type: ignore[no-untyped-def]


def no_return(self: Any, flour: Wheat): ...  # type: ignore[no-untyped-def]


def no_message(self: Any, flour: float) -> Bread: ...


def no_output(self: Any, flour: Wheat) -> float: ...


def odd_output(self: Any, flour: Wheat) -> Odd: ...


def any_output(self: Any, flour: Wheat) -> Message: ...


def any_outputs(self: Any, flour: Wheat) -> Outputs[Message]: ...


def any_field(self: Any, flour: Wheat) -> AnyField: ...


def any_source(self: Any) -> Source[Message]: ...


def many(self: Any, *flour: Wheat) -> Bread: ...


def unknown(self: Any, flour: Oats) -> Bread: ...  # type: ignore[name-defined]  # noqa: F821


def fed_source(self: Any, flour: Wheat) -> Source[Bread]: ...


def nothing(self: Any) -> Bread: ...


def asleep(self: Any, flour: Window[Wheat], order: Latest[Bread]) -> Bread: ...


def yielding(self: Any, flour: Wheat) -> Bread:
    yield Bread()  # type: ignore[misc]


async def later(self, flour: Wheat) -> Bread: ...  # type: ignore[no-untyped-def,empty-body]


def no_self(flour: Wheat) -> Bread: ...  # type: ignore[empty-body]


@pytest.mark.parametrize(
    ("process", "said"),
    [
        (no_types, "input flour has no type; write flour: MessageType"),
        (no_return, "write `-> None` for a sink"),
        (no_message, r"flour: MessageType, or MessageType in Joined, Latest, Nearest or Window"),
        (no_output, "return a message type, a dataclass of message types"),
        (odd_output, "return a message type, a dataclass of message types"),
        (any_output, "returns Message, the base of all messages: return the type that it sends"),
        (any_outputs, "returns Message, the base"),
        (any_field, "returns Message, the base"),
        (any_source, "returns Message, the base"),
        (many, "name each input"),
        (unknown, "an annotation that cannot be read: name 'Oats' is not defined"),
        (fed_source, "yields and has inputs; a source has none"),
        (nothing, r"a source returns Source\[MessageType\]"),
        (asleep, "sampled inputs only, so it would never fire"),
        (3, "define process"),
        (yielding, "return the message, or declare Outputs"),
        (later, "is async: write `def process`, and return Deferred"),
        (no_self, "has no self"),
    ],
)
def test_a_bad_signature_is_refused_with_what_to_write(process: Any, said: str) -> None:
    with pytest.raises(SignatureError, match=said):
        ports(stage(process))


class Unprepared(Stage):
    def __init__(self) -> None:
        self.loaves = 0

    def process(self, flour: Wheat) -> Bread: ...


class Plain(Stage):
    class Params:
        loaves: int = 0

    def process(self, flour: Wheat) -> Bread: ...


class Baker:
    def process(self, flour: Wheat) -> Bread: ...


def test_a_class_that_the_runtime_cannot_make_is_refused_with_what_to_write() -> None:
    with pytest.raises(SignatureError, match="takes no context: prepare in setup"):
        check_init(Unprepared)
    with pytest.raises(SignatureError, match=r"write class Params\(StageParams\)"):
        check_init(Plain)
    with pytest.raises(SignatureError, match=r"write class Baker\(Stage\)"):
        ports(Baker)  # type: ignore[arg-type]


def test_a_stage_that_lags_may_yield() -> None:
    def process(self: Any, flour: Wheat) -> Lagged[Bread]:
        yield Bread(1)

    assert ports(stage(process)).gives == "lagged"


def test_a_type_without_none_promises_a_message_for_each_firing() -> None:
    def some(self: Any, flour: Wheat) -> Bread | None: ...

    def nothing_at_all(self: Any, flour: Wheat) -> None: ...

    def one(self: Any, flour: Wheat) -> Bread: ...

    assert gives_always(stage(one))
    assert not gives_always(stage(some))
    assert not gives_always(stage(nothing_at_all))
