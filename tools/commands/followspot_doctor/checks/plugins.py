"""Plugins that do not work, and mistakes in a graph."""

from __future__ import annotations

from collections.abc import Iterator

from followspot.errors import InputError
from followspot.graph.compile import compile_graph
from followspot.plugins.catalogue import catalogue
from followspot.plugins.loaded_hooks import load_hooks
from followspot.plugins.registry import examined
from followspot_doctor.finding import Finding, fine, wrong

_REMEDIES = {
    "duplicate": "uninstall one of the two",
    "outdated": "upgrade the older of the two",
    "half-installed": "reinstall it",
    "broken": "reinstall it, or tell its author",
}


def stages() -> Iterator[Finding]:
    """Every installed stage is imported; one whose optional package is missing is no problem."""
    found = [examined(entry) for entry in catalogue().values()]
    missing: dict[str, list[str]] = {}
    for entry in found:
        if entry.state == "not installed":
            missing.setdefault(entry.problem, []).append(entry.name)
    for remedy, names in missing.items():
        yield fine("stages", f"not installed: {remedy} ({_few(names)})")
    bad = [entry for entry in found if entry.state not in ("ok", "not installed")]
    for entry in bad:
        yield wrong(f"stage {entry.name}", f"{entry.state}: {entry.problem}", _REMEDIES[entry.state])
    if not bad:
        well = [entry for entry in found if entry.state == "ok"]
        packages = {entry.distribution for entry in well}
        origin = f"{len(packages)} package{'s' * (len(packages) != 1)}"
        yield fine("plugins", f"{len(well)} stages of {origin}, all importable")


def _few(names: list[str]) -> str:
    """The names, or two of them and how many more there are."""
    return ", ".join(names if len(names) <= 3 else [*names[:2], f"{len(names) - 2} more"])


def hooks() -> Iterator[Finding]:
    """Every package with commands is imported."""
    for module in load_hooks().modules:
        if module.problem:
            remedy = f"reinstall or uninstall {module.distribution}"
            yield wrong(f"commands of {module.name}", module.problem, remedy)


def graph(path: str, room: str | None) -> Iterator[Finding]:
    """The result of `followspot check`."""
    try:
        plan = compile_graph(path, room=room)
    except InputError as error:
        for mistake in error.mistakes:
            yield wrong(f"graph {mistake.place or path}", mistake.text, mistake.remedy)
    else:
        yield fine("graph", f"{plan.graph}: {len(plan.stages)} stages, {len(plan.edges)} edges")
