"""The installed stages and their states, from the metadata of distributions alone: nothing is imported."""

from __future__ import annotations

import importlib.util
import re
from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass, replace
from functools import cache
from importlib.metadata import Distribution, EntryPoint, entry_points, version
from itertools import groupby
from types import MappingProxyType
from typing import Literal

GROUP = "followspot.plugins.v1"
_OTHER_GROUPS = "followspot.plugins.v"
_VALUE = re.compile(r"\w+(\.\w+)*:\w+")

EntryState = Literal["ok", "duplicate", "outdated", "half-installed", "not installed", "broken"]
"""not installed: an optional package that the stage needs is missing."""


@dataclass(frozen=True)
class StageEntry:
    """One stage that a distribution offers; problem: one line, empty if state is ok."""

    name: str
    value: str
    distribution: str
    version: str = ""
    state: EntryState = "ok"
    problem: str = ""


@cache
def catalogue() -> Mapping[str, StageEntry]:
    """All installed stages by name; nothing is imported."""
    installed = entry_points()
    groups = [group for group in installed.groups if group.startswith(_OTHER_GROUPS)]
    return read_catalogue(entry for group in groups for entry in installed.select(group=group))


def read_catalogue(entries: Iterable[EntryPoint]) -> Mapping[str, StageEntry]:
    """The stages of distributions with their states; the entries of a distribution must be adjacent."""
    found: dict[str, StageEntry] = {}
    for distribution, offered in groupby(entries, key=lambda entry: entry.dist):
        if distribution is not None:
            for stage in _stages(distribution, offered):
                _add(found, stage)
    return MappingProxyType(dict(sorted(found.items())))


def is_builtin(name: str) -> bool:
    """Whether a stage belongs to the distribution followspot, not to another."""
    entry = catalogue().get(name.partition("[")[0])
    return entry is not None and entry.distribution == "followspot"


def _add(found: dict[str, StageEntry], entry: StageEntry) -> None:
    known = found.get(entry.name)
    if known is None or known.state == "outdated":
        found[entry.name] = entry
    elif entry.state != "outdated":
        both = " and ".join(sorted((known.distribution, entry.distribution)))
        found[entry.name] = replace(
            known, state="duplicate", problem=f"offered by both {both}; uninstall one"
        )


def _stages(distribution: Distribution, entries: Iterable[EntryPoint]) -> Iterator[StageEntry]:
    """The stages of one distribution; its metadata is parsed once, since every process start waits for it."""
    name, release, unfit = distribution.name, distribution.version, _unfit(distribution)
    for entry in entries:
        state, problem = _judged(entry, name, unfit)
        yield StageEntry(entry.name, entry.value, name, release, state, problem)


def _judged(entry: EntryPoint, distribution: str, unfit: str) -> tuple[EntryState, str]:
    """State and problem of an entry; unfit: why its whole distribution is outdated, empty if it is not."""
    if _VALUE.fullmatch(entry.value) is None:
        return "broken", f"{distribution} registers {entry.value!r} where package.module:Class belongs"
    if entry.group != GROUP:
        speaks = f"{distribution} speaks {entry.group}, this followspot {GROUP}"
        return "outdated", f"{speaks}; upgrade the older of the two"
    if unfit:
        return "outdated", unfit
    package = entry.module.partition(".")[0]
    if importlib.util.find_spec(package) is None:
        return "half-installed", f"package {package} of {distribution} is missing; reinstall {distribution}"
    return "ok", ""


def _unfit(distribution: Distribution) -> str:
    """Why a distribution does not fit this version of followspot; empty if it fits."""
    for text in distribution.requires or ():
        if text.startswith("followspot") and (problem := _unmet(text)):
            return f"{distribution.name} {problem}"
    return ""


def _unmet(text: str) -> str:
    """The unmet part of a requirement on followspot; empty if it is met, or names another package."""
    from packaging.requirements import InvalidRequirement, Requirement  # slow, and few need it

    try:
        requirement = Requirement(text)
    except InvalidRequirement:
        return ""
    present = version("followspot")
    if requirement.name != "followspot" or requirement.specifier.contains(present, prereleases=True):
        return ""
    return f"needs followspot {requirement.specifier}, this is {present}"
