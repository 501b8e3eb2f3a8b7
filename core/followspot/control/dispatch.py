"""Control messages and their dispatch: typed requests, one handler for each type, a typed answer.

Carriers (`call`, pipe, unix socket, Zenoh) move a request as JSON and know none of them by name.
"""

from __future__ import annotations

import re
from collections.abc import Callable, Mapping
from functools import cache
from typing import Any, ClassVar

import pydantic

from followspot.errors import FollowspotError


class Request(pydantic.BaseModel):
    """Base of all requests: immutable, unknown fields are errors.

    answer: type of what the handler returns, None for nothing.
    """

    model_config = pydantic.ConfigDict(frozen=True, extra="forbid")
    answer: ClassVar[Any] = None


class UnknownRequest(FollowspotError):
    """Nobody here handles a request of this name."""


def verb(kind: type[Request]) -> str:
    """Name of a request on the wire: ``GetStatus`` is ``get_status``."""
    return re.sub(r"(?<!^)(?=[A-Z])", "_", kind.__name__).lower()


def to_wire(request: Request) -> dict[str, Any]:
    """The request in JSON types."""
    return {"verb": verb(type(request)), **request.model_dump(mode="json")}


def answer_from_wire(kind: type[Request], data: Any) -> Any:
    """The answer to a request of this type from JSON types. Raises ValueError."""
    return _adapter(kind).validate_python(data)


class Dispatcher:
    """Hands each request to the handler of its type.

    handlers: get the request, return its answer, raise FollowspotError to refuse it.
    """

    def __init__(self, handlers: Mapping[type[Request], Callable[[Any], Any]]) -> None:
        self._handlers = dict(handlers)
        self._kinds = {verb(kind): kind for kind in handlers}

    def dispatch(self, request: Request) -> Any:
        """The answer, or what the handler raises. Raises UnknownRequest."""
        handler = self._handlers.get(type(request))
        if handler is None:
            raise UnknownRequest(self._unknown(verb(type(request))))
        return handler(request)

    def dispatch_wire(self, data: Any) -> Any:
        """The same for a request in JSON types, and the answer in JSON types. Raises ValueError as well."""
        if not isinstance(data, Mapping):
            raise ValueError("a request is a JSON object")
        kind = self._kinds.get(str(data.get("verb")))
        if kind is None:
            raise UnknownRequest(self._unknown(str(data.get("verb"))[:80]))
        fields = {name: value for name, value in data.items() if name != "verb"}
        answer = self.dispatch(kind.model_validate(fields))
        return _adapter(kind).dump_python(answer, mode="json")

    def _unknown(self, name: str) -> str:
        return f"there is no request {name!r}; known: {', '.join(sorted(self._kinds))}"


@cache
def _adapter(kind: type[Request]) -> pydantic.TypeAdapter[Any]:
    """Built when the first answer travels, for a process that only asks in person needs none."""
    return pydantic.TypeAdapter(kind.answer)
