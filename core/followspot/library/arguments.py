"""Arguments of `Graph.add`: inputs and parameters, in the form of a graph file."""

from __future__ import annotations

from collections.abc import Collection, Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any, Literal

import numpy as np

from followspot.errors import FollowspotError


@dataclass(frozen=True)
class PortOf:
    """An output port of a stage, to feed inputs from; port: "" for the only one."""

    stage: str
    port: str = ""
    delay: int = 0
    depth: int | None = None
    policy: Literal["block", "drop_oldest", "latest"] | None = None

    def delayed(self, firings: int) -> PortOf:
        """Feedback: the message of `firings` firings ago."""
        return replace(self, delay=firings)

    def queued(self, depth: int, policy: Literal["block", "drop_oldest", "latest"] | None = None) -> PortOf:
        """The port with an edge of this depth (messages) and this policy for a full edge in a live run."""
        return replace(self, depth=depth, policy=policy)

    def to_data(self) -> Any:
        """The port in the form of a graph file."""
        name = f"{self.stage}.{self.port}" if self.port else self.stage
        more = {"delay": self.delay or None, "depth": self.depth, "policy": self.policy}
        given = {key: value for key, value in more.items() if value is not None}
        return {"from": name, **given} if given else name


class StageOf:
    """A stage of a graph. Its outputs are attributes: ``track.forecast``."""

    def __init__(self, name: str) -> None:
        self.name = name

    def __getattr__(self, port: str) -> PortOf:
        if port.startswith("_"):
            raise AttributeError(port)
        return PortOf(self.name, port)

    def __repr__(self) -> str:
        return f"<stage {self.name}>"


def inputs_and_params(
    stage: str, arguments: Mapping[str, Any], inputs: Collection[str]
) -> tuple[dict[str, Any], dict[str, Any]]:
    """The inputs and the parameters among a stage's arguments, in the form of a graph file.

    What is fed from a stage is an input, known or not, so that a check names the one that was meant. Raises
    FollowspotError for a value that a file cannot hold.
    """
    fed = {key for key, value in arguments.items() if key in inputs or _feeds(value)}
    feeds = {key: _feed(value) for key, value in arguments.items() if key in fed}
    params = {}
    for key, value in arguments.items():
        if key in fed:
            continue
        try:
            params[key] = _plain(value)
        except TypeError as error:
            raise FollowspotError(f'parameter "{key}" of stage "{stage}" holds {error}') from None
    return feeds, params


def refuse_fed(options: Mapping[str, Any]) -> None:
    """Raise FollowspotError if an option is fed from a stage: it has the name of an input."""
    fed = next((key for key, value in options.items() if _feeds(value)), None)
    if fed is not None:
        raise FollowspotError(f'"{fed}" is an option of `add`: feed such an input in a graph file')


def _feeds(value: Any) -> bool:
    """Whether a value is a stage or a port, or a list of these."""
    if isinstance(value, list | tuple):
        return bool(value) and all(map(_feeds, value))
    return isinstance(value, StageOf | PortOf)


def _feed(value: Any) -> Any:
    """The sender of an input in the form of a graph file. Raises FollowspotError."""
    if isinstance(value, StageOf):
        return value.name
    if isinstance(value, PortOf):
        return value.to_data()
    if isinstance(value, Sequence) and not isinstance(value, str):
        return [_feed(item) for item in value]
    raise FollowspotError(f"an input is fed from a stage or a port, not from {value!r}")


def _plain(value: Any) -> Any:
    """A parameter in YAML's types. Raises TypeError for a value of another one."""
    if isinstance(value, np.generic | np.ndarray):
        value = value.tolist()
    if isinstance(value, Path):
        return str(value.absolute())
    if isinstance(value, Mapping):
        return {str(key): _plain(item) for key, item in value.items()}
    if isinstance(value, list | tuple):
        return [_plain(item) for item in value]
    if value is None or isinstance(value, bool | int | float | str):
        return value
    raise TypeError(f"a {type(value).__name__}; a graph file takes numbers, text, lists and mappings")
