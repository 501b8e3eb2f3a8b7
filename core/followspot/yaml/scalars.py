"""Scalars of YAML 1.2 core: only `true` and `false` are truth values, and `012` is twelve."""

from __future__ import annotations

import math
import re

MAX_DIGITS = 100
"""Longest number, characters."""
LARGEST_INT = (1 << 63) - 1
"""Whole numbers fit into 64 bits."""

Scalar = str | int | float | bool | None
STR_TAG = "tag:yaml.org,2002:str"
"""Tag of a text."""
_INT = re.compile(r"[-+]?[0-9]+|0o[0-7]+|0x[0-9a-fA-F]+")
_FLOAT = re.compile(r"[-+]?(\.[0-9]+|[0-9]+(\.[0-9]*)?)([eE][-+]?[0-9]+)?")
_WORDS: dict[str, Scalar] = {
    **dict.fromkeys(("", "~", "null", "Null", "NULL")),
    **dict.fromkeys(("true", "True", "TRUE"), True),
    **dict.fromkeys(("false", "False", "FALSE"), False),
    **{sign + dot: float(sign + "inf") for sign in ("", "+", "-") for dot in (".inf", ".Inf", ".INF")},
    **dict.fromkeys((".nan", ".NaN", ".NAN"), float("nan")),
}


def resolve(text: str) -> Scalar:
    """The value of an unquoted scalar. Raises ValueError with the reason if a number is too large."""
    if text in _WORDS:
        return _WORDS[text]
    whole = _INT.fullmatch(text)
    if not whole and not _FLOAT.fullmatch(text):
        return text
    if len(text) > MAX_DIGITS:
        raise ValueError("this number has too many digits")
    if not whole:
        return _checked_number(float(text))
    return _checked_number(int(text, {"0o": 8, "0x": 16}.get(text[:2], 10)))


def _checked_number(value: float) -> float:
    """The number, whole or not. Raises ValueError if it is infinite or does not fit into 64 bits."""
    if isinstance(value, int):
        if not fits(value):
            raise ValueError("this whole number does not fit into 64 bits")
    elif math.isinf(value):
        raise ValueError("this number is too large")
    return value


def fits(value: int) -> bool:
    """Whether a whole number fits into 64 bits."""
    return -LARGEST_INT - 1 <= value <= LARGEST_INT
