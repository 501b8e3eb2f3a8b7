"""Pieces that several schemas are made of."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

Schema = dict[str, Any]

NAME = "^[A-Za-z0-9_][A-Za-z0-9_-]*$"
TEXT: Schema = {"type": "string", "minLength": 1}
FREE: Schema = {"type": "object"}


def form(description: str, keys: Mapping[str, Schema], required: Sequence[str] = ()) -> Schema:
    """A mapping with these keys and no others."""
    found: Schema = {
        "type": "object",
        "description": description,
        "properties": dict(keys),
        "additionalProperties": False,
    }
    return {**found, "required": list(required)} if required else found


def named(description: str, value: Schema) -> Schema:
    """A mapping of names that the user chooses."""
    return {
        "type": "object",
        "description": description,
        "propertyNames": {"pattern": NAME},
        "additionalProperties": value,
    }


def numbers(count: int, description: str) -> Schema:
    """A list of so many numbers."""
    return {
        "type": "array",
        "items": {"type": "number"},
        "minItems": count,
        "maxItems": count,
        "description": description,
    }


def matrix(description: str) -> Schema:
    """Three rows of three numbers."""
    rows = numbers(3, description)
    return {**rows, "items": numbers(3, "one row")}
