"""Which stages are installed and in which state, from metadata alone; the import of those in use."""

from __future__ import annotations

import importlib
import importlib.util
import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cache
from importlib.metadata import Distribution, EntryPoint, distributions, version
from types import MappingProxyType
from typing import Literal

from packaging.requirements import InvalidRequirement, Requirement

from followspot.errors import FollowspotError, did_you_mean
from followspot.plugins.one_file import FileStage, load_file
from followspot.ports import ports
from followspot.stage import Stage

GROUP = "followspot.plugins.v1"
_OTHER_GROUPS = "followspot.plugins.v"
_SEE = "`followspot plugins` lists every plugin and its state"
_VALUE = re.compile(r"\w+(\.\w+)*:\w+")

State = Literal["ok", "duplicate", "outdated", "half-installed", "broken"]


@dataclass(frozen=True)
class StageEntry:
    """One stage that a distribution offers; problem: one line, empty where state is ok."""

    name: str
    value: str
    distribution: str
    version: str = ""
    state: State = "ok"
    problem: str = ""


class PluginError(FollowspotError):
    """A stage cannot be used; problem: one line says which plugin and why; remedy: what to do."""

    def __init__(self, problem: str, remedy: str = "") -> None:
        super().__init__(problem + (f"; {remedy}" if remedy else ""))
        self.problem = problem
        self.remedy = remedy


_files: dict[str, FileStage] = {}


def use_plugin_files(paths: Sequence[str]) -> None:
    """Load one-file plugins; their stages are named FILE.class_name. Raises PluginError."""
    for path in paths:
        for stage in load_file(path):
            known = _files.get(stage.name)
            if known is not None and known.path != stage.path:
                raise PluginError(f"{path}: stage {stage.name} is already offered by {known.path}")
            if stage.name in catalogue():
                taken = catalogue()[stage.name].distribution
                raise PluginError(
                    f"{path}: stage {stage.name} is already offered by {taken}; rename the file"
                )
            _files[stage.name] = stage


@cache
def catalogue() -> Mapping[str, StageEntry]:
    """All installed stages by name; nothing is imported."""
    return read_catalogue(list(distributions()))


def read_catalogue(installed: Sequence[Distribution]) -> Mapping[str, StageEntry]:
    """The stages that distributions offer, each with its state; of one installed twice the first counts."""
    found: dict[str, StageEntry] = {}
    seen: set[str] = set()
    for distribution in installed:
        if distribution.name in seen:
            continue
        seen.add(distribution.name)
        for entry in distribution.entry_points:
            if entry.group.startswith(_OTHER_GROUPS):
                _add(found, _entry(entry, distribution))
    return MappingProxyType(dict(sorted(found.items())))


def stage_names() -> list[str]:
    """Names of all stages that can be asked for."""
    return sorted({*catalogue(), *_files})


def load_stage(name: str) -> type[Stage]:
    """Import a stage. Raises PluginError with one clear line."""
    if name in _files:
        return _files[name].stage
    entry = catalogue().get(name)
    if entry is None:
        raise PluginError(f'no stage "{name}" is installed', did_you_mean(name, stage_names(), "stages"))
    if entry.state != "ok":
        raise PluginError(f"{name}: {entry.problem}", _SEE)
    stage, problem = _import(entry)
    if stage is None:
        raise PluginError(f"{name}: {problem}", _SEE)
    return stage


def examined(entry: StageEntry) -> StageEntry:
    """The entry after an attempt to import it: broken, with the reason, where that fails."""
    if entry.state != "ok":
        return entry
    stage, problem = _import(entry)
    return entry if stage is not None else replace(entry, state="broken", problem=problem)


def _add(found: dict[str, StageEntry], entry: StageEntry) -> None:
    known = found.get(entry.name)
    if known is None or known.state == "outdated":
        found[entry.name] = entry
    elif entry.state != "outdated":
        both = " and ".join(sorted((known.distribution, entry.distribution)))
        found[entry.name] = replace(
            known, state="duplicate", problem=f"offered by both {both}; uninstall one"
        )


def _entry(entry: EntryPoint, distribution: Distribution) -> StageEntry:
    found = StageEntry(entry.name, entry.value, distribution.name, distribution.version)
    if _VALUE.fullmatch(entry.value) is None:
        problem = f"{distribution.name} registers {entry.value!r} where package.module:Class belongs"
        return replace(found, state="broken", problem=problem)
    outdated = _outdated(entry, distribution)
    if outdated:
        return replace(found, state="outdated", problem=outdated)
    package = entry.module.partition(".")[0]
    if importlib.util.find_spec(package) is None:
        missing = f"package {package} of {distribution.name} is missing; reinstall {distribution.name}"
        return replace(found, state="half-installed", problem=missing)
    return found


def _outdated(entry: EntryPoint, distribution: Distribution) -> str:
    """Why a plugin is of another time than this followspot; empty where it is not."""
    if entry.group != GROUP:
        return (
            f"{distribution.name} speaks {entry.group}, this followspot {GROUP}; upgrade the older of the two"
        )
    for text in distribution.requires or ():
        try:
            requirement = Requirement(text)
        except InvalidRequirement:
            continue
        ours = version("followspot")
        if requirement.name == "followspot" and not requirement.specifier.contains(ours, prereleases=True):
            return f"{distribution.name} needs followspot {requirement.specifier}, this is {ours}"
    return ""


@cache
def _import(entry: StageEntry) -> tuple[type[Stage] | None, str]:
    """The stage class, or why there is none."""
    module, _, attribute = entry.value.partition(":")
    try:
        found = getattr(importlib.import_module(module), attribute, None)
    except (Exception, SystemExit) as error:
        reason = " ".join(f"{type(error).__name__}: {error}".split())
        return None, f"{entry.distribution} fails on import: {reason}"
    if not (isinstance(found, type) and issubclass(found, Stage)):
        return None, f"{entry.distribution} is half installed: {module} has no stage class {attribute}"
    try:
        ports(found)
    except FollowspotError as error:
        return None, f"{entry.distribution} is broken: {error}"
    return found, ""
