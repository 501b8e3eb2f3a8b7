"""Features of a camera, checked against the camera's own description of them: GenApi, or controls of V4L2."""

from __future__ import annotations

from collections.abc import Callable, Collection, Iterator, Mapping
from dataclasses import dataclass
from math import isfinite

from followspot.errors import Guess, InputError, Mistake

Value = bool | int | float | str


@dataclass(frozen=True)
class Feature:
    """One feature of a camera.

    kind: of its node: Integer, Float, Enumeration, Boolean, String, Command, or another; entries: of an
    enumeration; low, high: limits of a number, None if unknown; unit: as the camera writes it.
    """

    name: str
    kind: str
    writable: bool = True
    entries: tuple[str, ...] = ()
    low: float | None = None
    high: float | None = None
    unit: str = ""


def set_features(
    wanted: Mapping[str, Value],
    names: Collection[str],
    feature: Callable[[str], Feature | None],
    write: Callable[[str, Value], None],
    origin: str,
    noun: str = "feature",
) -> None:
    """Set the features that a user wants, one after the other.

    Each is held against what the camera tells of it then, because one feature may decide about the limits of
    the next, or lock it. wanted: name -> value; names: of all features of the camera; feature: finds one by
    its name; write: sets one, and raises ValueError if the camera refuses; origin: the camera, and noun: what
    its kind calls a feature, for the texts. Raises InputError with all mistakes.
    """
    found: list[Mistake] = []
    for name, value in wanted.items():
        known = feature(name) if name in names else None
        if known is None:
            text = f'{origin} has no {noun} "{name}"'
            found.append(Mistake(None, text, Guess(name, f"its {noun}s", names)))
        elif wrong := list(_wrong(known, value, origin)):
            found += wrong
        else:
            try:
                write(name, value)
            except ValueError as error:
                text = f'{origin} does not take "{value}" as {name}: {error}'
                found.append(Mistake(None, text, f"give another value, or set other {noun}s before it"))
    if found:
        raise InputError(found)


def as_text(value: Value) -> str:
    """The value as node maps read it."""
    return str(value).lower() if isinstance(value, bool) else str(value)


def _wrong(known: Feature, value: Value, origin: str) -> Iterator[Mistake]:
    """The mistake in the value of a feature that the camera has."""
    name = known.name
    if not known.writable:
        text = f"{name} of {origin} cannot be set"
        yield Mistake(
            None, text, "leave it out, or set before it what locks it, such as GainAuto: Off for Gain"
        )
    elif known.kind == "Command":
        yield Mistake(None, f"{name} of {origin} is a command, and has no value", "leave it out")
    elif known.kind == "Enumeration" and str(value) not in known.entries:
        text = f'{name} of {origin} cannot be "{value}"'
        yield Mistake(None, text, Guess(str(value), "its values", known.entries))
    elif known.kind == "Boolean" and not isinstance(value, bool):
        yield Mistake(None, f'{name} of {origin} cannot be "{value}"', "write true or false")
    elif known.kind in ("Integer", "Float"):
        yield from _wrong_number(known, value, origin)


def _wrong_number(known: Feature, value: Value, origin: str) -> Iterator[Mistake]:
    numeric = isinstance(value, int | float) and not isinstance(value, bool) and isfinite(value)
    if not numeric or (known.kind == "Integer" and value != int(value)):
        whole = "a whole number" if known.kind == "Integer" else "a number"
        yield Mistake(None, f'{known.name} of {origin} cannot be "{value}"', f"write {whole}")
        return
    low, high = known.low, known.high
    if (low is not None and float(value) < low) or (high is not None and float(value) > high):
        text = f"{known.name} of {origin} cannot be {value:g}"
        limits = f"{'any' if low is None else f'{low:g}'} to {'any' if high is None else f'{high:g}'}"
        yield Mistake(None, text, f"write a number from {limits} {known.unit}".strip())
