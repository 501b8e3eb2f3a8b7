"""The module and the test of a stage that takes and gives the types that are asked for."""

from __future__ import annotations

import re
from collections.abc import Sequence
from importlib import import_module

from followspot.errors import InputError, did_you_mean
from followspot.messages import Message

_MODULES = ("followspot.tracking", "followspot.people", "followspot.points", "followspot.inertial")
BASES = ("Field", "Source", "Stage", "StageParams")
"""Classes that a module of a stage takes from followspot."""
_BODY = '''

class {name}(Stage):
    """{about}"""
{serves}
    class Params(StageParams):
        share: float = Field(1.0, ge=0, le=1, description="what it does", unit="1")

    params: Params

    def process(self{inputs}) -> {gives}:
        """{about}"""
{work}
'''
_TEST = '''"""Promises of {plugin}.{stage}."""

from __future__ import annotations

from followspot.testing import check_stage
from followspot_{plugin}.{stage} import {name}


def test_every_promise_of_a_stage_is_kept() -> None:
    check_stage({name})
'''


def message_types() -> dict[str, str]:
    """Name of each message type that comes with followspot -> its module."""
    found = {}
    for module in _MODULES:
        for name, kind in vars(import_module(module)).items():
            if isinstance(kind, type) and issubclass(kind, Message) and kind.__module__ == module:
                found[name] = module
    return found


def stub(name: str, takes: Sequence[str], gives: str | None) -> str:
    """The text of a module with a stage that does nothing yet. Raises InputError for unknown types.

    name: of the class; takes: types of the inputs, none of a source; gives: that of the output, None of a
    sink.
    """
    known = message_types()
    for kind in (*takes, *([gives] if gives else [])):
        if kind not in known:
            raise InputError.of(f'there is no message type "{kind}"', did_you_mean(kind, known, "types"))
    if len({*takes}) < len(takes):
        raise InputError.of("a type stands twice in --takes", "once; Joined[...] collects several messages")
    if not takes and not gives:
        raise InputError.of("the stage takes and gives nothing", "for example: --takes Blobs --gives Blobs")
    about = f"{_words(takes, gives)}."
    result = f"Source[{gives}]" if not takes else gives or "None"
    inputs = "".join(f", {_snake(kind)}: {kind}" for kind in takes)
    work = _work(known, takes, gives)
    serves = "\n    per_camera = True\n" if "self.camera" in work else ""
    body = _BODY.format(name=name, about=about, serves=serves, inputs=inputs, gives=result, work=work)
    return f'"""{about}"""\n\nfrom __future__ import annotations\n\n{_imports(known, takes, gives)}\n{body}'


def stub_test(plugin: str, stage: str, name: str) -> str:
    """The text of the test module of a stub."""
    return _TEST.format(plugin=plugin, stage=stage, name=name)


def _words(takes: Sequence[str], gives: str | None) -> str:
    if not takes:
        return f"Send {gives}, so far an empty message a second"
    if gives is None:
        return f"Receive {' and '.join(takes)}, so far without a use"
    return f"Pass {gives} on" if gives in takes else f"Make {gives} of {' and '.join(takes)}, so far none"


def _work(known: dict[str, str], takes: Sequence[str], gives: str | None) -> str:
    """The body of `process`."""
    if gives is None:
        return f'        self.log.info("a message of %d ns", {_snake(takes[0])}.header.time)'
    if gives in takes:
        return f"        return {_snake(gives)}"
    of_camera = [kind for kind in takes if _names_camera(known, kind)]
    camera = f"{_snake(of_camera[0])}.camera" if of_camera else "self.camera.name"
    empty = f"{gives}.empty({f'camera={camera}' if _names_camera(known, gives) else ''})"
    if takes:
        return f"        return {empty}"
    return f"        for second in range(10):\n            yield at(second * 1_000_000_000, {empty})"


def _names_camera(known: dict[str, str], kind: str) -> bool:
    """Whether messages of a type say of which camera they are."""
    return "camera" in dict(getattr(import_module(known[kind]), kind).scalars)


def _imports(known: dict[str, str], takes: Sequence[str], gives: str | None) -> str:
    """Lines as a formatter sorts them."""
    ours = "Field, Stage, StageParams" if takes else "Field, Source, Stage, StageParams, at"
    used = {*takes, *([gives] if gives else [])}
    modules = sorted({known[kind] for kind in used})
    lines = [f"from {one} import {', '.join(sorted(k for k in used if known[k] == one))}" for one in modules]
    return "\n".join([f"from followspot import {ours}", *lines])


def _snake(kind: str) -> str:
    return re.sub(r"(?<=[a-z0-9])(?=[A-Z])", "_", kind).lower()
