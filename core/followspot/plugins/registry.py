"""The stages that a graph can use: installed ones, those of one-file plugins, and classes of this process."""

from __future__ import annotations

import importlib
import re
from collections.abc import Sequence
from dataclasses import replace
from functools import cache
from itertools import chain, count
from pathlib import Path

from followspot.errors import FollowspotError, Guess, did_you_mean
from followspot.messages import Message
from followspot.operating_system.standard_output import importing
from followspot.plugins.catalogue import StageEntry, catalogue
from followspot.plugins.extras import missing_extra
from followspot.plugins.one_file import FileStage, load_file
from followspot.ports.signature import SignatureError, check_init, ports
from followspot.stage import Stage

_SEE = "`followspot plugins` lists every plugin and its state"


class PluginError(FollowspotError):
    """A stage cannot be used; problem: one line with the plugin and the reason; remedy: advice."""

    def __init__(self, problem: str, remedy: str | Guess = "") -> None:
        super().__init__(problem, remedy)
        self.problem = problem
        self.remedy = remedy

    def __str__(self) -> str:
        return self.problem + (f"; {self.remedy}" if self.remedy else "")


_files: dict[str, FileStage] = {}


def use_plugin_files(paths: Sequence[str], *, changed: bool = False) -> None:
    """Load one-file plugins; their stages are named FILE.class_name. Raises PluginError.

    changed: load a file again that was changed since.
    """
    for path in paths:
        stages = load_file(path, changed=changed)
        for stage in stages:
            known = _files.get(stage.name)
            if known is not None and known.path != stage.path:
                raise PluginError(
                    f"{path}: stage {stage.name} is already offered by {known.path}; rename one of the files,"
                    " for stages are named by file and class, whatever the folder"
                )
            if stage.name in catalogue():
                taken = catalogue()[stage.name].distribution
                raise PluginError(
                    f"{path}: stage {stage.name} is already offered by {taken}; rename the file"
                )
            _files[stage.name] = stage
        offered = {stage.name for stage in stages}
        for name in [name for name, known in _files.items() if known.path == path and name not in offered]:
            del _files[name]


def file_stages(paths: Sequence[str]) -> list[StageEntry]:
    """The stages of one-file plugins, as far as these can be loaded; any other file is one broken entry."""
    broken = []
    for path in paths:
        try:
            use_plugin_files([path])
        except FollowspotError as error:
            broken.append(StageEntry(Path(path).stem, path, path, state="broken", problem=str(error)))
    stages = [one for one in _files.values() if one.path in paths]
    return [*(StageEntry(one.name, one.stage.__qualname__, one.path) for one in stages), *broken]


_offered: dict[str, type[Stage]] = {}
"""Stages of this process alone, by name."""
OFFERED = "here."
"""Prefix of the names of stages that exist in this process only."""


def offer_stage(stage: type[Stage]) -> str:
    """Register a class of this process for its graphs; returns its name in a graph.

    Another class of the same name has a number behind it, for a graph that was made before runs its own, for
    example if a notebook's cell runs again. Raises SignatureError if it is no stage.
    """
    if not isinstance(stage, type):
        raise SignatureError(f"{stage!r:.80} is no class: a graph makes its stages itself, give it the class")
    ports(stage)
    check_init(stage)
    first = OFFERED + re.sub(r"(?<!^)(?=[A-Z])", "_", stage.__name__).lower()
    names = chain([first], (f"{first}_{number}" for number in count(2)))
    return next(name for name in names if _offered.setdefault(name, stage) is stage)


def stage_names() -> list[str]:
    """Names of all stages that a graph can use."""
    return sorted({*catalogue(), *_files})


def load_stage(name: str) -> type[Stage]:
    """Import a stage. Raises PluginError with one clear line.

    NAME[STAGE.PORT] is the stage NAME for the message type of that port of an installed stage.
    """
    general, bracket, port = name.partition("[")
    if bracket:
        return _for_port(general, port.removesuffix("]"))
    if name in _files:
        return _files[name].stage
    if name in _offered:
        return _offered[name]
    if name.startswith(OFFERED):
        raise PluginError(
            f"{name} exists only in the process that offers it",
            "put it into a file, and name that with --plugin",
        )
    entry = catalogue().get(name)
    if entry is None:
        raise PluginError(f'no stage "{name}" is installed', did_you_mean(name, stage_names(), "stages"))
    if entry.state != "ok":
        raise PluginError(f"{name}: {entry.problem}", _SEE)
    stage, entry = _import(entry)
    if stage is None and entry.state == "not installed":
        raise PluginError(f"{name}: not installed", entry.problem)
    if stage is None:
        raise PluginError(f"{name}: {entry.problem}", _SEE)
    return stage


def _for_port(name: str, port: str) -> type[Stage]:
    """A stage that serves any type, for the type of STAGE.PORT. Raises PluginError."""
    general = load_stage(name)
    sender, _, output = port.rpartition(".")
    if general.for_type is None or "[" in sender:
        raise PluginError(f"{name} cannot be asked for by a port", f"uses: {name}")
    sent = ports(load_stage(sender)).outputs
    found = next((one.type for one in sent if one.name == output), None)
    if found is None:
        known = did_you_mean(output, [one.name for one in sent], "outputs")
        raise PluginError(f'stage {sender} has no output "{output}"', known)
    return _for_type(general, found)  # type: ignore[arg-type]  # classes can be hashed


@cache
def _for_type(general: type[Stage], kind: type[Message]) -> type[Stage]:
    """A stage that serves any type, for this one."""
    assert general.for_type is not None
    made: type[Stage] = general.for_type(kind)
    return made


def examined(entry: StageEntry) -> StageEntry:
    """The entry after an attempt to import it: broken or not installed, with the reason, if that fails."""
    return _import(entry)[1] if entry.state == "ok" else entry


@cache
def _import(entry: StageEntry) -> tuple[type[Stage] | None, StageEntry]:
    """The stage class, or none and the entry with the reason."""
    module, _, attribute = entry.value.partition(":")
    try:
        with importing():
            found = getattr(importlib.import_module(module), attribute, None)
    except ModuleNotFoundError as error:
        if remedy := missing_extra(entry.distribution, error.name or ""):
            return None, replace(entry, state="not installed", problem=remedy)
        return _broken(entry, f"fails on import: {type(error).__name__}: {error}")
    except (Exception, SystemExit) as error:
        return _broken(entry, f"fails on import: {type(error).__name__}: {error}")
    if not (isinstance(found, type) and issubclass(found, Stage)):
        return _broken(entry, f"is half installed: {module} has no stage class {attribute}")
    try:
        ports(found)
        check_init(found)
    except FollowspotError as error:
        return _broken(entry, f"is broken: {error}")
    return found, entry


def _broken(entry: StageEntry, reason: str) -> tuple[None, StageEntry]:
    problem = " ".join(f"{entry.distribution} {reason}".split())
    return None, replace(entry, state="broken", problem=problem)
