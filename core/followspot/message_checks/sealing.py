"""Seals a message before it is sent: checks it against its contract, and makes its arrays read-only."""

from __future__ import annotations

import ctypes
import math
from functools import lru_cache
from mmap import mmap
from typing import Any

import numpy as np

from followspot.message_checks.type_names import named_type, named_value
from followspot.messages import (
    MAX_BYTES,
    MAX_INTEGER,
    MAX_TEXTS,
    MIN_INTEGER,
    Array,
    InvalidMessage,
    M,
    Message,
)

_SURELY_SHORT = MAX_TEXTS // 5
"""Characters, and texts of a tuple, that `MAX_TEXTS` allows whatever they are."""

_FEW_BYTES = 4096
"""Number of bytes up to which a call of numpy costs more than a search byte by byte."""


def seal(message: M) -> M:
    """Check a message against its contract, make its arrays contiguous and read-only, and return it.

    An edge between processes delivers contiguous arrays and plain scalars. An edge within a process must
    deliver the same, because sums over another memory layout may differ in the last bit; and it delivers the
    values of now, whatever the stage writes to its own arrays later. Raises InvalidMessage.
    """
    values = message.__dict__
    length = 0
    for name, kind in message.scalars:
        value = values[name]
        if type(value) is not kind:
            values[name] = value = _plain(name, value, kind)
        if kind is int:
            if not MIN_INTEGER <= value <= MAX_INTEGER:
                raise InvalidMessage(f"{name} is no number of 64 bits")
        elif kind is not float and kind is not bool:
            text = value if kind is str else "".join(value)
            length += len(text) + len(value)
            if not text.isascii():
                _check_text(name, text)
    if length > _SURELY_SHORT:
        _check_length(message)
    layout: list[Any] = []
    for name in message.array_names:
        array = values[name]
        if type(array) is not np.ndarray:
            raise InvalidMessage(f"{name} is {named_value(array)}, not a numpy array")
        if not array.flags.c_contiguous:
            values[name] = array = np.ascontiguousarray(array)
        elif array.base is not None:
            values[name] = array = _kept(array, array.base)
        array.setflags(False)  # write=False; the keyword would double the cost
        layout += array.shape, array.dtype
    _check_layout(type(message), tuple(layout))  # type: ignore[arg-type]  # classes can be hashed
    for name in message.truth_names:
        if beyond_truth(values[name]):  # it was a view of other numbers
            values[name] = truth = np.asarray(values[name] != 0)
            truth.setflags(write=False)
    return message


def _kept(array: Array, owner: Any) -> Array:
    """A view that does not change if the stage writes to the memory of `owner`, an array or a buffer.

    A part of a larger array is copied, since the stage may fill the rest; else the owner becomes read-only.
    The memory of a buffer (bytearray, ctypes) cannot become read-only, so a view of it is copied.
    """
    if type(owner) is np.ndarray:
        memory: Any = owner.base
        if memory is None or type(memory) is mmap:  # a loan is an array in shared memory
            if owner.flags.writeable:
                if owner.nbytes > array.nbytes:
                    return array.copy()
                owner.setflags(write=False)
            return array
        owner = memory
    buffer = isinstance(owner, (memoryview, ctypes.Array))
    return array.copy() if buffer and not memoryview(owner).readonly else array


def beyond_truth(array: Array) -> bool:
    """Whether an array of truth values, contiguous, holds bytes other than 0 and 1."""
    if array.nbytes < _FEW_BYTES:
        return array.tobytes().translate(None, b"\0\1") != b""
    return bool(np.count_nonzero(array.view(np.uint8) > 1))


@lru_cache(maxsize=4096)  # most messages repeat a few layouts
def _check_layout(kind: type[Message], layout: tuple[Any, ...]) -> None:
    """Compare the shape and dtype of each column with its declaration. Raises InvalidMessage."""
    sizes: dict[str, int] = {}
    total = 0
    for (name, declared, wanted, *_), shape, dtype in zip(
        kind.columns, layout[::2], layout[1::2], strict=True
    ):
        if dtype != wanted:
            raise InvalidMessage(f"{name} has dtype {dtype}, declared {wanted}")
        check_shape(name, shape, declared, sizes)
        total += math.prod(shape) * dtype.itemsize
    if total > MAX_BYTES:
        raise InvalidMessage(f"{total} bytes, at most {MAX_BYTES} allowed")


def _plain(name: str, value: Any, kind: Any) -> Any:
    """The value in exactly the declared type. Raises InvalidMessage if the conversion would change it."""
    if isinstance(value, np.generic):
        value = value.item()
    if kind is float and type(value) is int:
        value = float(value)
    if kind == tuple[str, ...]:
        matches = type(value) is tuple and set(map(type, value)) <= {str}
    else:
        matches = type(value) is kind
    if not matches:
        raise InvalidMessage(f"{name} is {named_value(value)}, declared {named_type(kind)}")
    return value


def _check_text(name: str, text: str) -> None:
    """Raise InvalidMessage if a text cannot be encoded."""
    try:
        text.encode()
    except UnicodeEncodeError as error:
        raise InvalidMessage(f"{name} is no Unicode text: {error}") from None


def _check_length(message: Message) -> None:
    """Raise InvalidMessage if the texts of a message are too long together."""
    fields = [
        (name, getattr(message, name)) for name, kind in message.scalars if kind in (str, tuple[str, ...])
    ]
    texts = [text for _, value in fields for text in ((value,) if isinstance(value, str) else value)]
    size = sum(len(text.encode()) + 3 for text in texts)
    if size > MAX_TEXTS:
        names = ", ".join(name for name, _ in fields)
        raise InvalidMessage(f"the texts ({names}) have {size} bytes, at most {MAX_TEXTS} allowed")


def check_shape(
    name: str, actual: tuple[int, ...], declared: tuple[int | str, ...], sizes: dict[str, int]
) -> None:
    """Compare a shape with its declaration; named sizes are bound in `sizes`. Raises InvalidMessage."""
    if len(actual) == len(declared):
        for size, want in zip(actual, declared):  # noqa: B905  # as long, which was asked above
            if size != want and (isinstance(want, int) or size != sizes.setdefault(want, size)):
                break
        else:
            return
    raise InvalidMessage(f"{name} has shape {actual}, declared {declared} with {sizes}")
