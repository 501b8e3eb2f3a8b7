"""Checkpoints: the state of a stage in JSON types, without loss of precision."""

from __future__ import annotations

import base64
from collections.abc import Mapping
from typing import Any

import numpy as np

from followspot.messages import MAX_BYTES

_ARRAY = "\0array"
"""Key that marks an array; it begins with a null so that no key of a stage equals it."""


def state_to_data(state: Any) -> Any:
    """The state in JSON types: numbers, text, None, arrays, lists, tuples, and mappings with text as keys.

    Raises TypeError if the state contains anything else.
    """
    if isinstance(state, np.generic):
        state = np.asarray(state)
    if isinstance(state, np.ndarray):
        if state.dtype.kind not in "biufc":
            raise TypeError(f"an array of {state.dtype}")
        data = base64.b64encode(np.ascontiguousarray(state).tobytes()).decode()
        return {_ARRAY: data, "dtype": state.dtype.str, "shape": list(state.shape)}
    if isinstance(state, Mapping):
        return {_name(key): state_to_data(value) for key, value in state.items()}
    if isinstance(state, list | tuple):
        return [state_to_data(item) for item in state]
    if state is None or isinstance(state, bool | int | float | str):
        return state
    raise TypeError(f"a {type(state).__name__}")


def state_from_data(data: Any) -> Any:
    """The inverse of `state_to_data`; tuples become lists. Raises ValueError, TypeError, KeyError."""
    if isinstance(data, dict) and _ARRAY in data:
        dtype = np.dtype(str(data["dtype"]))
        if dtype.kind not in "biufc":
            raise ValueError(f"an array of {dtype}")
        raw = base64.b64decode(data[_ARRAY], validate=True)
        if len(raw) > MAX_BYTES:
            raise ValueError(f"an array of {len(raw)} bytes")
        return np.frombuffer(raw, dtype).reshape(data["shape"]).copy()
    if isinstance(data, dict):
        return {key: state_from_data(value) for key, value in data.items()}
    if isinstance(data, list):
        return [state_from_data(item) for item in data]
    return data


def _name(key: Any) -> str:
    if not isinstance(key, str):
        raise TypeError(f"a key that is a {type(key).__name__}, not text")
    return key
