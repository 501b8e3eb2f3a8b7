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
    """Base of all requests: immutable, unknown fields are errors; checked when the first one is made.

    roles: which processes handle it; answer: type of what the handler returns, None for nothing;
    open_to_hosts: whether other hosts may ask an agent, not operators alone; long_answer: whether the answer
    travels back in a request, and so may be as long as one.
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


class UnknownRequest(FollowspotError, ValueError):
    """No request of this name is understood here."""


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
    """The request from JSON types. kinds: types that are understood, by verb.

    Raises UnknownRequest, ValueError.
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
"""By type: get the request, return its answer, raise FollowspotError to refuse it."""


class Dispatcher:
    """Hands each request to the handler of its type.

    role: of this process.
    """

    def __init__(self, role: Role, handlers: Handlers) -> None:
        """Raises TypeError if a request is for another role."""
        if foreign := [kind.__name__ for kind in handlers if role not in kind.roles]:
            raise TypeError(f"requests that no {role} handles: {', '.join(foreign)}")
        self._handlers = dict(handlers)
        self.kinds = by_verb(handlers)
        """Types of the requests that are handled, by their names on the wire."""

    def dispatch(self, request: Request, *beside: Any) -> Any:
        """The answer, or what the handler raises. Raises UnknownRequest.

        beside: what travelled beside the request, for its handler.
        """
        handler = self._handlers.get(type(request))
        if handler is None:
            raise UnknownRequest(_unknown(verb(type(request)), self.kinds))
        return handler(request, *beside)

    def dispatch_wire(self, data: Any) -> Any:
        """The same for a request in JSON types, and the answer in JSON types. Raises ValueError as well."""
        request = from_wire(self.kinds, data)
        return answer_to_wire(type(request), self.dispatch(request))


def _unknown(name: str, kinds: Iterable[str]) -> str:
    return f"there is no request {name!r}; known: {', '.join(sorted(kinds))}"


class _Answer(pydantic.RootModel[Any]):
    """Base of all answers; NaN and infinity arrive as they are."""

    model_config = pydantic.ConfigDict(ser_json_inf_nan="constants")


@cache
def _answer(kind: type[Request]) -> type[_Answer]:
    """Built when the first answer travels, for a process that only asks in person needs none."""
    return pydantic.create_model("Answer", __base__=_Answer, root=(kind.answer, ...))
