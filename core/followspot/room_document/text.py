"""The text of a room document, in YAML that people read and change."""

from __future__ import annotations

import json
import re
from collections.abc import Mapping
from typing import Any

from followspot.yaml.scalars import resolve

_LINE = 100
"""Longest mapping that is written on one line, in characters."""
_PLAIN_TEXT = re.compile(r"[A-Za-z_/][A-Za-z0-9_./+-]*")
_UNPRINTABLE = re.compile(r"[\x7f-\x9f\u2028\u2029\ufeff\ud800-\udfff\ufffe\uffff]")


def dump(data: Mapping[str, Any], indent: int = 0) -> str:
    """YAML: short mappings and lists of numbers on one line, matrices one row a line."""
    lines: list[str] = []
    pad = " " * indent
    for key, value in data.items():
        label, flow = f"{pad}{_flow(str(key))}:", _flow(value)
        if _is_matrix(value):
            lines += [f"{label}\n", *(f"{pad}  - {_flow(row)}\n" for row in value)]
        elif isinstance(value, Mapping) and value and (len(label) + len(flow) > _LINE or _nests(value)):
            lines += [f"{label}\n", dump(value, indent + 2)]
        else:
            lines.append(f"{label} {flow}\n")
    return "".join(lines)


def _is_matrix(value: Any) -> bool:
    return isinstance(value, list) and bool(value) and all(isinstance(row, list) for row in value)


def _nests(value: Mapping[str, Any]) -> bool:
    return any(_is_matrix(child) or isinstance(child, Mapping) for child in value.values())


def _flow(value: Any) -> str:
    """A value on one line; floats keep every bit."""
    if isinstance(value, Mapping):
        return "{" + ", ".join(f"{_flow(str(k))}: {_flow(v)}" for k, v in value.items()) + "}"
    if isinstance(value, list | tuple):
        return "[" + ", ".join(_flow(item) for item in value) + "]"
    if isinstance(value, float):
        text = repr(value)
        # YAML 1.1 readers parse 1e-05 as a text.
        return text if "." in text or "e" not in text else text.replace("e", ".0e")
    if isinstance(value, str):
        return value if _PLAIN_TEXT.fullmatch(value) and resolve(value) == value else _quoted(value)
    return json.dumps(value)


def _quoted(text: str) -> str:
    return _UNPRINTABLE.sub(lambda found: f"\\u{ord(found[0]):04x}", json.dumps(text, ensure_ascii=False))
