"""Messages: immutable payloads of numpy arrays and scalars, and the header that the runtime puts on them.

A message type is a class with annotated fields; arrays are declared with :func:`column`, which states
shape, dtype and unit once, for the type checker, the wire format and the reader of the code::

    class Blobs(Message):
        camera: str
        xy: Array = column("N", 2, unit="px")

Structure of arrays, never arrays of structures: one column per quantity, rows correspond.
The message types of tracking itself stand in `followspot.tracking`.
"""

from __future__ import annotations

import dataclasses
import math
import operator
from typing import Any, ClassVar, NamedTuple, Self, TypeVar, dataclass_transform, get_type_hints

import numpy as np
from numpy.typing import NDArray

from followspot.columns import Column, check_column
from followspot.tables.html import html_table
from followspot.tables.table_column import TableColumn

Array = NDArray[Any]

MAX_BYTES = 1 << 28
"""Largest message that any edge accepts, in bytes."""
MAX_TEXTS = 62_000
"""Most bytes that the texts of a message take together, in UTF-8 and with 3 bytes for the length of each: so
they fit into a head with all else (`followspot.transport.wire.MAX_HEAD`)."""
MAX_TIME = 1 << 62
"""Largest absolute capture time, ns (146 years from 1970). A watermark, with every tolerance and lateness
that a graph can add, stays below the values that mean absence and the end (`followspot.transport.token`)."""
MAX_SEQ = 1 << 62
"""Largest number of a frame."""
MIN_INTEGER, MAX_INTEGER = -(1 << 63), (1 << 63) - 1
"""Smallest and largest integer that a field holds."""


class Header(NamedTuple):
    """Source, number and capture time of a message."""

    source: str
    """Name of the source stage, for example ``camera/cam0``."""
    seq: int
    """Number of the frame at that source, from 0."""
    time: int
    """Capture time, ns."""
    entered: int = 0
    """Time at which the source sent it, ns of the host's monotonic clock; for latency only."""


UNSTAMPED = Header("", -1, 0)


SCALARS: tuple[type, ...] = (str, int, float, bool)


def column(
    *shape: int | str,
    dtype: str = "f8",
    unit: str = "1",
    refers: str = "",
    names: str = "",
    decimals: int | None = None,
    extra: bool = False,
) -> Any:
    """Declare an array field: sizes are numbers, or names that must agree within one message.

    dtype: a numpy type code, by default float64; unit: of the values ("px", "m", "1"); refers: for indices,
    what they index ("targets" of the room, "states" of a target, or a field of the message that is a tuple of
    texts, such as "cameras").

    In a table each number of a row has a column. names: of these columns, separated by spaces, by default
    x, y, z for `xyz`, `object` for targets, else sigma_0, sigma_1 for `sigma`; decimals: digits after the
    point in text files; extra: whether text files leave it out.
    """
    metadata = (shape, np.dtype(dtype), unit, refers, tuple(names.split()), decimals, extra)
    return dataclasses.field(metadata=dict(zip(Column._fields[1:], metadata, strict=True)))


@dataclass_transform(frozen_default=True, eq_default=False, field_specifiers=(column,))
class Message:
    """Base of all messages. Subclasses become frozen dataclasses; the runtime stamps `header`."""

    header: ClassVar[Header] = UNSTAMPED  # a stamped instance has its own
    columns: ClassVar[tuple[Column, ...]] = ()
    array_names: ClassVar[tuple[str, ...]] = ()
    truth_names: ClassVar[tuple[str, ...]] = ()
    """Of the columns of truth values."""
    scalars: ClassVar[tuple[tuple[str, Any], ...]] = ()
    rows_of: ClassVar[str] = ""
    """The column that has as many entries as the message has rows; empty if it always says something."""

    def __init_subclass__(cls) -> None:
        dataclasses.dataclass(frozen=True, eq=False)(cls)
        hints = get_type_hints(cls)
        cls.columns = tuple(
            Column(f.name, **f.metadata)
            for f in dataclasses.fields(cls)  # type: ignore[arg-type]  # it became one two lines ago
            if "shape" in f.metadata
        )
        cls.array_names = tuple(c.name for c in cls.columns)
        cls.truth_names = tuple(c.name for c in cls.columns if c.dtype == bool)
        cls.scalars = tuple(
            (f.name, hints[f.name])
            for f in dataclasses.fields(cls)  # type: ignore[arg-type]
            if f.name not in cls.array_names
        )
        named = [c.name for c in cls.columns[:1] if c.shape and isinstance(c.shape[0], str)]
        numbers = any(kind in (int, float, bool) for _, kind in cls.scalars)
        cls.rows_of = named[0] if named and not numbers else ""
        cls._check_declaration()

    @classmethod
    def _check_declaration(cls) -> None:
        """Raise TypeError if a field's type cannot be sent, or the declaration of a column is wrong."""
        for name in (*cls.array_names, *dict(cls.scalars)):
            if name in vars(Message):
                raise TypeError(f"{cls.__name__}.{name}: a message has this name already; take another one")
        for name, kind in cls.scalars:
            if kind not in SCALARS and kind != tuple[str, ...]:
                raise TypeError(
                    f"{cls.__name__}.{name}: a field is a column(), str, int, float, bool or tuple[str, ...]"
                )
        texts = {name for name, kind in cls.scalars if kind == tuple[str, ...]}
        for c in cls.columns:
            check_column(cls.__name__, c)
            if c.refers and c.refers not in ("targets", "states", *texts):
                what = "neither targets, states nor a field of texts"
                raise TypeError(f"{cls.__name__}.{c.name} refers to {c.refers}: {what}")
            if c.names and (
                str in map(type, c.shape[1:]) or len(c.names) != math.prod(map(int, c.shape[1:]))
            ):
                raise TypeError(f"{cls.__name__}.{c.name} has other numbers in a row than names")

    @classmethod
    def empty(cls, **fields: Any) -> Self:
        """A message without rows: named sizes are 0, scalars are empty. fields: those that are not.

        A delayed edge gives it, without fields, until the first message of n frames ago exists.
        """
        values: dict[str, Any] = {name: (kind() if kind in SCALARS else ()) for name, kind in cls.scalars}
        for name, shape, dtype, *_ in cls.columns:
            values[name] = np.zeros([0 if isinstance(size, str) else size for size in shape], dtype)
        return cls(**(values | fields))

    @property
    def is_empty(self) -> bool:
        """Whether it says nothing: its first column has a named size, which is 0, and it has no number."""
        name = type(self).rows_of
        return name != "" and not len(getattr(self, name))

    def where(self, keep: Array | slice) -> Self:
        """The message with only these rows, in every column as long as the first.

        keep: a mask (N,), row numbers (K,) or a slice.
        """
        rows = self.columns[0].shape[0]
        kept = {c.name: getattr(self, c.name)[keep] for c in self.columns if c.shape[:1] == (rows,)}
        return dataclasses.replace(self, **kept)  # type: ignore[type-var]

    def as_table(self, room: Any) -> list[TableColumn] | None:
        """The table of the message, for a type that makes its own; None if it follows from the declaration.

        room: a `followspot.room.Room`, for names. Without rows, the columns have the same names.
        """
        return None

    def _repr_html_(self) -> str:
        fields = [(name, "", "", str(getattr(self, name))) for name, _ in self.scalars]
        for c in self.columns:
            array = getattr(self, c.name)
            values = np.array2string(array, threshold=60, edgeitems=2, precision=4)
            fields.append((c.name, " x ".join(map(str, array.shape)), c.unit, values))
        source, seq, time, _ = self.header
        title = f"{type(self).__name__} {seq} of {source or 'no source'} at {time} ns"
        return html_table(("field", "shape", "unit", "value"), fields, title)


M = TypeVar("M", bound=Message)


class InvalidMessage(ValueError):
    """A message does not match its contract; the text says which field and why."""


def stamped(message: M, header: Header) -> M:
    """The message with this header; a copy if a stage sent it before, because other stages may hold it."""
    if message.header.source:
        copy = object.__new__(type(message))
        copy.__dict__.update(message.__dict__)
        message = copy
    message.__dict__["header"] = header  # only the runtime may set it
    return message


def at(time: int, message: M, *, seq: int = -1, due: int = 0) -> M:
    """A message with its capture time, for a source to yield.

    time: ns; seq: the frame's number if the source knows it (a video with gaps), else the runtime counts.
    due: the runtime sends it no earlier, ns of `time.monotonic_ns`, and other stages work until then; a live
    source has a thread and waits there. A live source that does not know the capture time yields plain
    messages: the runtime takes the time of arrival. Raises InvalidMessage if a number is out of range,
    TypeError if it is not a whole number.
    """
    try:
        header = Header("", operator.index(seq), operator.index(time), operator.index(due))
    except TypeError:
        raise TypeError(
            f"at({time!r}, ..., seq={seq!r}, due={due!r}): all are whole; write round(seconds * 1e9)"
        ) from None
    return stamped(message, in_range(header))


def in_range(header: Header) -> Header:
    """The header, if its numbers are so small that the runtime cannot overflow. Raises InvalidMessage."""
    _, seq, time, entered = header
    if -MAX_TIME <= time <= MAX_TIME and -1 <= seq <= MAX_SEQ and -MAX_TIME <= entered <= MAX_TIME:
        return header
    raise InvalidMessage(
        f"the header {str(tuple(header))[:160]} has a number out of range: times lie within {MAX_TIME} ns "
        f"before and after 1970, frames are numbered from 0 to {MAX_SEQ}"
    )


def identical(a: Message, b: Message) -> bool:
    """Whether two messages are equal bit for bit, in type, time and every field."""
    return (
        type(a) is type(b)
        and a.header[:3] == b.header[:3]
        and all(repr(getattr(a, name)) == repr(getattr(b, name)) for name, _ in a.scalars)  # NaN is NaN
        and all(
            getattr(a, c.name).shape == getattr(b, c.name).shape
            and getattr(a, c.name).tobytes() == getattr(b, c.name).tobytes()
            for c in a.columns
        )
    )
