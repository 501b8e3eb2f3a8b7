"""Digests of the code of stages, by which two hosts tell whether they run the same."""

from __future__ import annotations

import hashlib
import sys
from collections.abc import Iterable, Iterator, Mapping
from pathlib import Path

import numpy as np

from followspot.files import read_bytes
from followspot.plugins.registry import OFFERED, load_stage
from followspot.ports.signature import ports
from followspot.stage import Stage


def code_digests(stages: Iterable[str]) -> dict[str, str]:
    """Digests of followspot and of each package and one-file plugin that these stages are made of, by name.

    These are the packages of their classes, of the stages that they derive from, and of their messages.
    Classes that exist in this process only have none. Raises PluginError, SignatureError, OSError.
    """
    classes = [load_stage(stage) for stage in stages if not stage.startswith(OFFERED)]
    modules = {part.__module__ for stage in classes for part in _parts(stage)}
    return dict(map(_digest, sorted({"followspot", *(name.partition(".")[0] for name in modules)})))


def library_versions() -> dict[str, str]:
    """Versions of what computes for every stage: the same code may give other numbers with another one."""
    import cv2

    python = ".".join(map(str, sys.version_info[:2]))
    return {"Python": python, "numpy": np.__version__, "OpenCV": cv2.__version__}


def other_code(digests: Mapping[str, str], stages: Iterable[str]) -> list[str]:
    """Names of libraries, and of the packages and files of these stages, that are not as the digests tell.

    digests: those of the other host, with the versions of its libraries. Raises PluginError,
    SignatureError, OSError.
    """
    here = code_digests(stages) | library_versions()
    return [name for name, own in here.items() if digests.get(name, own) != own]


def _parts(stage: type[Stage]) -> Iterator[type]:
    """A class with the stages that it derives from, and the types of its messages."""
    yield from (base for base in stage.__mro__ if issubclass(base, Stage))
    found = ports(stage)
    yield from (port.type for port in found.inputs)
    yield from (port.type for port in found.outputs)


def _digest(module: str) -> tuple[str, str]:
    """Name and digest of the Python files of a package, or of the one file of a module."""
    found = sys.modules[module]
    folder = next(iter(getattr(found, "__path__", ())), None)
    files = [Path(found.__file__ or "")] if folder is None else sorted(Path(folder).rglob("*.py"))
    digest = hashlib.sha256()
    for path in files:
        digest.update(f"{path.relative_to(folder or path.parent)}\0".encode())
        digest.update(hashlib.sha256(read_bytes(path)).digest())
    return files[0].name if folder is None else module, digest.hexdigest()
