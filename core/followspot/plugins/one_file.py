"""One-file plugins: `--plugin FILE.py` offers each stage class of the file as FILE.class_name."""

from __future__ import annotations

import importlib.util
import re
import sys
import traceback
from dataclasses import dataclass
from functools import cache
from importlib.abc import SourceLoader
from pathlib import Path

from followspot.errors import FollowspotError
from followspot.files import DOCUMENT, read_bytes
from followspot.ports import SignatureError, ports
from followspot.stage import Stage


class PluginFileError(FollowspotError):
    """A one-file plugin cannot be loaded; the text names file and line."""


@dataclass(frozen=True)
class FileStage:
    """A stage that a file offers."""

    name: str
    path: str
    stage: type[Stage]


class _Loader(SourceLoader):
    """Runs the source that was read, so that the file cannot be another one meanwhile."""

    def __init__(self, path: str, source: bytes) -> None:
        self.path = path
        self.source = source

    def get_filename(self, fullname: str) -> str:
        """The file, as tracebacks name it."""
        return self.path

    def get_data(self, path: str | bytes) -> bytes:
        """The source."""
        return self.source


@cache
def load_file(path: str) -> tuple[FileStage, ...]:
    """Run the file once and collect the stages that it defines. Raises PluginFileError."""
    file = Path(path)
    if not re.fullmatch(r"[a-z_][a-z0-9_]*\.py", file.name):
        raise PluginFileError(f"{path}: name it like a Python module, lower case, for example my_fusion.py")
    try:
        loader = _Loader(path, read_bytes(file, DOCUMENT))
    except OSError as error:
        raise PluginFileError(f"{path} cannot be read: {error.strerror}") from None
    module_name = f"followspot_file_{file.stem}"
    spec = importlib.util.spec_from_file_location(module_name, file, loader=loader)
    assert spec is not None
    module = importlib.util.module_from_spec(spec)
    sys.modules[module_name] = module  # annotations are resolved there
    try:
        loader.exec_module(module)
    except (Exception, SystemExit) as error:
        del sys.modules[module_name]
        raise PluginFileError(f"{path}:{_line(error, path)}: {type(error).__name__}: {error}") from error
    classes = [c for c in vars(module).values() if isinstance(c, type) and c.__module__ == module_name]
    stages = [c for c in classes if issubclass(c, Stage)]
    if not stages:
        raise PluginFileError(f"{path}: defines no stage; a stage is a class derived from followspot.Stage")
    for stage in stages:
        _check_signature(stage, path)
    return tuple(FileStage(f"{file.stem}.{_snake(c.__name__)}", path, c) for c in stages)


def _check_signature(stage: type[Stage], path: str) -> None:
    try:
        ports(stage)
    except SignatureError as error:
        raise PluginFileError(f"{path}: {error}") from None


def _line(error: BaseException, path: str) -> int:
    """Line of the file in which it went wrong."""
    if isinstance(error, SyntaxError):
        return error.lineno or 1
    lines = [frame.lineno for frame in traceback.extract_tb(error.__traceback__) if frame.filename == path]
    return (lines[-1] or 1) if lines else 1


def _snake(name: str) -> str:
    return re.sub(r"(?<=[a-z0-9])(?=[A-Z])", "_", name).lower()
