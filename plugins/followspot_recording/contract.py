"""The contract of a message type as JSON: the schema of a recorded port (docs/recordings.md)."""

from __future__ import annotations

import json
import keyword
from typing import Any

import numpy as np

from followspot import Message
from followspot.columns import Column
from followspot.errors import FollowspotError
from followspot.messages import SCALARS, Array, column

_KINDS: dict[str, Any] = {kind.__name__: kind for kind in SCALARS} | {"texts": tuple[str, ...]}
_MAX_FIELDS = 200


class ContractError(FollowspotError):
    """A text is no contract of a message type."""


def type_name(kind: type[Message]) -> str:
    """Module and name of a message type, for example followspot.tracking.Blobs."""
    return f"{kind.__module__}.{kind.__qualname__}"


def contract_of(kind: type[Message]) -> str:
    """The contract as JSON text."""
    names = {value: name for name, value in _KINDS.items()}
    return json.dumps(
        {
            "type": type_name(kind),
            "scalars": {name: names[scalar] for name, scalar in kind.scalars},
            "columns": {
                c.name: {"shape": list(c.shape), "dtype": c.dtype.str, "unit": c.unit} | _table(c)
                for c in kind.columns
            },
        }
    )


def is_of(contract: str, kind: type[Message]) -> bool:
    """True if messages of this contract are messages of the type; names in tables make no difference.

    Raises ContractError.
    """
    made = message_type(contract)
    return (
        made.__name__ == kind.__name__
        and made.scalars == kind.scalars
        and list(map(_layout, made.columns)) == list(map(_layout, kind.columns))
    )


def _layout(c: Column) -> tuple[str, tuple[int | str, ...], np.dtype[Any], str]:
    """What the arrays of a column are, without how tables show them."""
    return c.name, c.shape, c.dtype, c.unit


def message_type(contract: str) -> type[Message]:
    """A message type of this contract, for messages whose own type is not installed. Raises ContractError."""
    try:
        found = json.loads(contract)
        name = str(found["type"]).rpartition(".")[2]
        hints: dict[str, Any] = {field: _KINDS[kind] for field, kind in found["scalars"].items()}
        columns = {field: _column(said) for field, said in found["columns"].items()}
    except (ValueError, KeyError, TypeError, AttributeError, RecursionError) as error:
        raise ContractError(f"no contract of a message type: {type(error).__name__}: {error}") from None
    fields = {**hints, **dict.fromkeys(columns, Array)}
    if len(fields) > _MAX_FIELDS or not all(map(_is_field, (name, *fields))):
        raise ContractError(f"no contract of a message type: impossible names in {contract[:200]}")
    try:
        return type(name, (Message,), {"__annotations__": fields, "__module__": __name__, **columns})
    except TypeError as error:
        raise ContractError(f"no contract of a message type: {error}") from None


def _table(c: Column) -> dict[str, Any]:
    """The keys of a column that only tables need, if the column has them."""
    return ({"refers": c.refers} if c.refers else {}) | ({"names": list(c.names)} if c.names else {})


def _column(said: Any) -> Any:
    shape = [size if isinstance(size, int) else str(size) for size in said["shape"]]
    dtype = np.dtype(str(said["dtype"]))
    if dtype.kind not in "biufc":
        raise ValueError(f"dtype {dtype} is not made of plain numbers")
    refers, names = str(said.get("refers", "")), " ".join(map(str, said.get("names", ())))
    return column(*shape, dtype=dtype.str, unit=str(said["unit"]), refers=refers, names=names)


def _is_field(name: str) -> bool:
    """Whether a name from a file may become an attribute of a message."""
    taken = hasattr(Message, name)
    return name.isidentifier() and not keyword.iskeyword(name) and not name.startswith("_") and not taken
