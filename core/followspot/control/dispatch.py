"""Control messages and their dispatch: typed requests, one handler for each type, a typed answer.

Carriers (an in-process call, a pipe, a unix socket, Zenoh) move a request as JSON and know no verb.
"""

from __future__ import annotations

import re
from collections.abc import Callable, Iterable, Mapping
from functools import cache
from typing import Any, ClassVar, Literal

import pydantic

from followspot.errors import FollowspotError

Role = Literal["operator", "host", "worker"]
"""Process that handles a request: the run's operator, a host (its agent, or the operator's own), a worker."""


class Request(pydantic.BaseModel):
    """Base of all requests: immutable; unknown fields are errors. Validators are built at first use.

    roles: roles whose processes handle it; answer: type of the answer, None for no answer; open_to_hosts:
    True if other hosts may ask it of an agent, not only operators; long_answer: True if later requests carry
    the answer, so that it may be as long as a request.
    """

    model_config = pydantic.ConfigDict(
        frozen=True, extra="forbid", defer_build=True, ser_json_inf_nan="constants"
    )
    roles: ClassVar[tuple[Role, ...]]
    answer: ClassVar[Any] = None
    open_to_hosts: ClassVar[bool] = False
    long_answer: ClassVar[bool] = False


class RunRequest(Request):
    """A request that concerns one run. run: its name, "" if the role that handles it has only one."""

    run: str = ""


Ask = Callable[[Request, float], Any]
"""Sends a request to the run and returns its answer; the number is the timeout, s.

Raises NoAnswer after the timeout, FollowspotError if the run has ended or refuses.
"""


class NoAnswer(FollowspotError):
    """The run's process is alive but does not answer in time: it is suspended or too busy."""


class UnknownRequest(FollowspotError, ValueError):
    """The process handles no request of this name."""


def verb(kind: type[Request]) -> str:
    """Name of a request on the wire: ``GetStatus`` is ``get_status``."""
    return re.sub(r"(?<!^)(?=[A-Z])", "_", kind.__name__).lower()


def to_wire(request: Request) -> dict[str, Any]:
    """The request in JSON types."""
    return {"verb": verb(type(request)), **fields(request)}


def fields(request: Request) -> dict[str, Any]:
    """The fields of a request in JSON types."""
    return request.model_dump(mode="json")


def from_wire(kinds: Mapping[str, type[Request]], data: Any) -> Request:
    """The request from JSON types. kinds: the types that this process handles, by verb.

    Raises UnknownRequest for any other verb, ValueError for invalid fields.
    """
    if not isinstance(data, Mapping):
        raise ValueError("a request is a JSON object")
    kind = kinds.get(str(data.get("verb")))
    if kind is None:
        raise UnknownRequest(_unknown(str(data.get("verb"))[:80], kinds))
    return kind.model_validate({name: value for name, value in data.items() if name != "verb"})


def by_verb(kinds: Iterable[type[Request]]) -> Mapping[str, type[Request]]:
    """The types by their names on the wire."""
    return {verb(kind): kind for kind in kinds}


def answer_from_wire(kind: type[Request], data: Any) -> Any:
    """The answer to a request of this type from JSON types. Raises ValueError."""
    return _answer(kind).model_validate(data).root


def answer_to_wire(kind: type[Request], answer: Any) -> Any:
    """The answer to a request of this type in JSON types."""
    return _answer(kind).model_construct(answer).model_dump(mode="json")


Handlers = Mapping[type[Request], Callable[..., Any]]
"""Handlers by type: each gets the request and returns its answer, or raises FollowspotError to refuse it."""


class Dispatcher:
    """Passes each request to the handler of its type.

    role: of this process.
    """

    def __init__(self, role: Role, handlers: Handlers) -> None:
        """Raises TypeError if a request is for another role."""
        if foreign := [kind.__name__ for kind in handlers if role not in kind.roles]:
            raise TypeError(f"requests that no {role} handles: {', '.join(foreign)}")
        self._handlers = dict(handlers)
        self.kinds = by_verb(handlers)
        """The types of the handled requests, by their names on the wire."""

    def dispatch(self, request: Request, *beside: Any) -> Any:
        """The handler's answer. Raises UnknownRequest, and the errors of the handler.

        beside: further arguments for the handler, such as file descriptors that came with the request.
        """
        handler = self._handlers.get(type(request))
        if handler is None:
            raise UnknownRequest(_unknown(verb(type(request)), self.kinds))
        return handler(request, *beside)

    def dispatch_wire(self, data: Any) -> Any:
        """Dispatch a request in JSON types; returns JSON types. Raises ValueError if it is invalid."""
        request = from_wire(self.kinds, data)
        return answer_to_wire(type(request), self.dispatch(request))


def _unknown(name: str, kinds: Iterable[str]) -> str:
    return f"there is no request {name!r}; known: {', '.join(sorted(kinds))}"


class _Answer(pydantic.RootModel[Any]):
    """Base of all answers; NaN and infinity arrive as they are."""

    model_config = pydantic.ConfigDict(ser_json_inf_nan="constants")


@cache
def _answer(kind: type[Request]) -> type[_Answer]:
    """The validator of an answer; built at first use, because in-process calls do not need it."""
    return pydantic.create_model("Answer", __base__=_Answer, root=(kind.answer, ...))
