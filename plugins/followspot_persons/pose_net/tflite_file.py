"""The indices in a TensorFlow Lite file, which OpenCV follows without a look.

The file is a FlatBuffer: https://flatbuffers.dev/internals and TensorFlow's `schema.fbs`; tables name their
fields by number.
"""

from __future__ import annotations

from collections.abc import Iterator
from struct import Struct, error

_OPERATOR_CODES, _SUBGRAPHS, _BUFFERS = 1, 2, 4
"""Fields of a model."""
_TENSORS, _OPERATORS = 0, 3
"""Fields of a graph in it; its inputs and outputs have the numbers of those of an operator."""
_CODE, _INPUTS, _OUTPUTS = 0, 1, 2
"""Fields of an operator."""
_BUFFER = 2
"""Field of a tensor: its values."""
_UNSIGNED, _SIGNED, _SHORT = Struct("<I"), Struct("<i"), Struct("<H")
_MOST = 100_000
"""Most entries of a list that are followed."""


def check_indices(model: bytes) -> None:
    """Raise ValueError if an operator names a tensor or a code that is not there, or a tensor such values."""
    try:
        _check_model(model)
    except error:
        raise ValueError("the file is damaged: a part lies beyond its end") from None


def _check_model(model: bytes) -> None:
    root = _at(_UNSIGNED, model, 0)
    codes, buffers = (len(_list(model, root, field)) for field in (_OPERATOR_CODES, _BUFFERS))
    for graph in _tables(model, root, _SUBGRAPHS):
        tensors = list(_tables(model, graph, _TENSORS))
        for tensor in tensors:
            _check(_number(model, tensor, _BUFFER), buffers, "values")
        operators = list(_tables(model, graph, _OPERATORS))
        for operator in operators:
            _check(_number(model, operator, _CODE), codes, "operator")
        for table in (graph, *operators):
            for place in (*_list(model, table, _INPUTS), *_list(model, table, _OUTPUTS)):
                index = _at(_SIGNED, model, place)
                if index != -1:  # an optional input that is left out
                    _check(index, len(tensors), "tensor")


def _check(index: int, count: int, what: str) -> None:
    if not 0 <= index < count:
        raise ValueError(f"the file is damaged: it names {what} {index} of {count}")


def _at(kind: Struct, model: bytes, place: int) -> int:
    """The number at a place. Raises struct.error beyond the end."""
    if place < 0:
        raise error
    return int(kind.unpack_from(model, place)[0])


def _field(model: bytes, table: int, number: int) -> int | None:
    """Place of a field of a table; None if the table leaves it out."""
    fields = table - _at(_SIGNED, model, table)
    if 4 + 2 * number >= _at(_SHORT, model, fields):
        return None
    offset = _at(_SHORT, model, fields + 4 + 2 * number)
    return table + offset if offset else None


def _number(model: bytes, table: int, field: int) -> int:
    """A number, 0 by default."""
    place = _field(model, table, field)
    return 0 if place is None else _at(_UNSIGNED, model, place)


def _list(model: bytes, table: int, field: int) -> range:
    """Places of the entries of a list of four bytes each; none if it is left out. Raises ValueError."""
    place = _field(model, table, field)
    if place is None:
        return range(0)
    start = place + _at(_UNSIGNED, model, place)
    count = _at(_UNSIGNED, model, start)
    if count > _MOST:
        raise ValueError(f"the file is damaged: a list has {count} entries")
    return range(start + 4, start + 4 + 4 * count, 4)


def _tables(model: bytes, table: int, field: int) -> Iterator[int]:
    """Places of the tables in a list."""
    for place in _list(model, table, field):
        yield place + _at(_UNSIGNED, model, place)
