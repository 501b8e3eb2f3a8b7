"""followspot: plugin-based dataflow for room-scale multi-camera tracking.

In scripts and notebooks: `run`, `connect`, `check`, `Graph` and `open_recording`.

What plugin authors import: stages (`Stage`, `StageParams`, `Field`, `Latest`, `Joined` and other marks),
messages (`Message`, `column`, `at`) and the room. The message types of tracking stand in
`followspot.tracking`.
Nothing is imported before it is asked for, so that the command line answers at once.
"""

from __future__ import annotations

from importlib import import_module
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from followspot.context import Context
    from followspot.errors import FollowspotError, InputError, Mistake
    from followspot.library.connect import ConnectedRun, connect
    from followspot.library.graph import Graph
    from followspot.library.keep_options import Keep
    from followspot.library.own_run import OwnRun, RunFailed
    from followspot.library.recording import Recording, open_recording
    from followspot.library.report import Report
    from followspot.library.run import check, run
    from followspot.library.subscription import Subscription
    from followspot.library.table import Table
    from followspot.messages import Array, Header, Message, at, column
    from followspot.ports.marks import Deferred, Joined, Lagged, Latest, Nearest, Outputs, Source, Window
    from followspot.room import Camera, Member, Room, Sensor, Target
    from followspot.stage import Stage
    from followspot.stage_params import (
        Field,
        InputAddress,
        InputDevice,
        InputPath,
        OutputFolder,
        OutputHost,
        OutputPath,
        StageParams,
    )
    from followspot.transport.zenoh.network import Network

_HOME = {
    "FollowspotError": "errors",
    "InputError": "errors",
    "Mistake": "errors",
    "ConnectedRun": "library.connect",
    "connect": "library.connect",
    "Graph": "library.graph",
    "Keep": "library.keep_options",
    "Recording": "library.recording",
    "open_recording": "library.recording",
    "Report": "library.report",
    "OwnRun": "library.own_run",
    "RunFailed": "library.own_run",
    "check": "library.run",
    "run": "library.run",
    "Subscription": "library.subscription",
    "Table": "library.table",
    "Network": "transport.zenoh.network",
    "Array": "messages",
    "Header": "messages",
    "Message": "messages",
    "at": "messages",
    "column": "messages",
    "Camera": "room",
    "Member": "room",
    "Room": "room",
    "Sensor": "room",
    "Target": "room",
    "Context": "context",
    "Deferred": "ports.marks",
    "Field": "stage_params",
    "InputAddress": "stage_params",
    "InputDevice": "stage_params",
    "InputPath": "stage_params",
    "Joined": "ports.marks",
    "Lagged": "ports.marks",
    "Latest": "ports.marks",
    "Nearest": "ports.marks",
    "OutputHost": "stage_params",
    "OutputFolder": "stage_params",
    "OutputPath": "stage_params",
    "Outputs": "ports.marks",
    "Source": "ports.marks",
    "Stage": "stage",
    "StageParams": "stage_params",
    "Window": "ports.marks",
}

__all__ = [
    "Array",
    "Camera",
    "ConnectedRun",
    "Context",
    "Deferred",
    "Field",
    "FollowspotError",
    "Graph",
    "Header",
    "InputAddress",
    "InputDevice",
    "InputError",
    "InputPath",
    "Joined",
    "Keep",
    "Lagged",
    "Latest",
    "Member",
    "Message",
    "Mistake",
    "Nearest",
    "Network",
    "OutputFolder",
    "OutputHost",
    "OutputPath",
    "Outputs",
    "OwnRun",
    "Recording",
    "Report",
    "Room",
    "RunFailed",
    "Sensor",
    "Source",
    "Stage",
    "StageParams",
    "Subscription",
    "Table",
    "Target",
    "Window",
    "at",
    "check",
    "column",
    "connect",
    "open_recording",
    "run",
]


def __getattr__(name: str) -> Any:
    if name in _HOME:
        return getattr(import_module(f"followspot.{_HOME[name]}"), name)
    raise AttributeError(f"module 'followspot' has no attribute {name!r}")


def __dir__() -> list[str]:
    return sorted(__all__)
