"""Optional packages of a distribution: which of its extras installs a module that is missing."""

from __future__ import annotations

import re
from collections import defaultdict
from collections.abc import Iterable
from importlib.metadata import PackageNotFoundError, requires


def missing_extra(distribution: str, module: str) -> str:
    """How to install a module that an extra of the distribution would bring; empty if none does.

    The module is taken to be named like its package, but for dots, dashes and underscores. Of several extras,
    that with the fewest packages is named.
    """
    try:
        needs = requires(distribution) or ()
    except PackageNotFoundError:
        return ""
    extras = _extras(needs)
    wanted = _plain(module.partition(".")[0])
    offering = [name for name, packages in extras.items() if wanted and wanted in packages]
    if not offering:
        return ""
    smallest = min(offering, key=lambda name: (len(extras[name]), name))
    return f"pip install '{distribution}[{smallest}]'"


def _extras(needs: Iterable[str]) -> dict[str, list[str]]:
    """Plain names of the packages of each extra."""
    from packaging.requirements import InvalidRequirement, Requirement  # slow, and few need it

    found: dict[str, list[str]] = defaultdict(list)
    for text in needs:
        extra = re.search(r"""extra\s*==\s*["']([\w.-]+)["']""", text)
        try:
            package = Requirement(text).name
        except InvalidRequirement:
            continue
        if extra is not None:
            found[extra[1]].append(_plain(package))
    return found


def _plain(name: str) -> str:
    return re.sub(r"[-_.]", "", name).lower()
