"""One-file plugins: `--plugin FILE.py` offers each stage class of the file as FILE.class_name."""

from __future__ import annotations

import importlib.util
import inspect
import re
import sys
import traceback
from dataclasses import dataclass
from importlib.abc import SourceLoader
from pathlib import Path
from types import ModuleType

from followspot.errors import FollowspotError
from followspot.files import DOCUMENT, read_bytes
from followspot.operating_system.standard_output import importing
from followspot.ports.signature import SignatureError, check_init, ports
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


_loaded: dict[str, tuple[bytes, tuple[FileStage, ...]]] = {}
"""Source and stages of each file that was loaded."""


def load_file(path: str, *, changed: bool = False) -> tuple[FileStage, ...]:
    """Run the file once and collect the stages that it defines. Raises PluginFileError.

    changed: run it again if its source is another one than the last time.
    """
    known = _loaded.get(path)
    if known is not None and not changed:
        return known[1]
    source = _source(path)
    if known is None or known[0] != source:
        known = _loaded[path] = source, _stages(path, source)
    return known[1]


def _source(path: str) -> bytes:
    """The bytes of the file. Raises PluginFileError."""
    file = Path(path)
    if not re.fullmatch(r"[a-z_][a-z0-9_]*\.py", file.name):
        raise PluginFileError(f"{path}: name it like a Python module, lower case, for example my_fusion.py")
    try:
        return read_bytes(file, DOCUMENT)
    except OSError as error:
        raise PluginFileError(f"{path} cannot be read: {error.strerror}") from None


def _stages(path: str, source: bytes) -> tuple[FileStage, ...]:
    """The stages that the source of the file defines. Raises PluginFileError."""
    stem = Path(path).stem
    module_name = f"followspot_file_{stem}"
    module = _run(path, module_name, source)
    classes = [c for c in vars(module).values() if isinstance(c, type) and c.__module__ == module_name]
    stages = [c for c in classes if issubclass(c, Stage)]
    if not stages:
        raise PluginFileError(f"{path}: defines no stage; a stage is a class derived from followspot.Stage")
    for stage in stages:
        _check_signature(stage, path)
    return tuple(FileStage(f"{stem}.{_snake(c.__name__)}", path, c) for c in stages)


def _run(path: str, module_name: str, source: bytes) -> ModuleType:
    """The module that the source makes. Raises PluginFileError."""
    loader = _Loader(path, source)
    spec = importlib.util.spec_from_file_location(module_name, path, loader=loader)
    assert spec is not None
    module = importlib.util.module_from_spec(spec)
    before = sys.modules.get(module_name)
    sys.modules[module_name] = module  # annotations are resolved there
    try:
        with importing():
            loader.exec_module(module)
    except (Exception, SystemExit) as error:
        if before is None:
            del sys.modules[module_name]
        else:
            sys.modules[module_name] = before
        raise PluginFileError(f"{path}:{_line(error, path)}: {type(error).__name__}: {error}") from error
    return module


def _check_signature(stage: type[Stage], path: str) -> None:
    try:
        ports(stage)
        check_init(stage)
    except SignatureError as error:
        raise PluginFileError(f"{path}:{_line_of(stage, path)}: {error}") from None


def _line_of(stage: type[Stage], path: str) -> int:
    """Line of the file with the stage's `process`, else with its class."""
    code = getattr(getattr(stage, "process", None), "__code__", None)
    if code is not None and code.co_filename == path:
        return int(code.co_firstlineno)
    return inspect.findsource(stage)[1] + 1


def _line(error: BaseException, path: str) -> int:
    """Line of the file in which it went wrong."""
    if isinstance(error, SyntaxError):
        return error.lineno or 1
    lines = [frame.lineno for frame in traceback.extract_tb(error.__traceback__) if frame.filename == path]
    return (lines[-1] or 1) if lines else 1


def _snake(name: str) -> str:
    return re.sub(r"(?<=[a-z0-9])(?=[A-Z])", "_", name).lower()
