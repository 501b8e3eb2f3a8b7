"""Files from templates: nothing that exists is ever overwritten."""

from __future__ import annotations

import keyword
import re
import tomllib
from collections.abc import Mapping, Sequence
from importlib.metadata import version
from pathlib import Path
from string import Template

from followspot.errors import InputError, writing
from followspot.graph.declaration import ROOM_SOURCE
from followspot.plugins.catalogue import catalogue
from followspot.plugins.registry import OFFERED
from followspot_new.stub import BASES, message_types, stub, stub_test

TEMPLATES = Path(__file__).parent / "templates"
GROUP = '[project.entry-points."followspot.plugins.v1"]'
_PLUGIN_NAME = re.compile(r"[a-z][a-z0-9]{0,39}")
_STAGE_NAME = re.compile(r"[a-z][a-z0-9]*(_[a-z0-9]+)*")
_FIRST = "low"

PLUGIN_FILES: Mapping[str, str] = {
    "pyproject.toml": "pyproject.toml",
    "README.md": "README.md",
    ".gitignore": "gitignore",
    ".github/workflows/test.yml": "test.yml",
    "followspot_$plugin/__init__.py": "init.py",
    "followspot_$plugin/py.typed": "py.typed",
    "graph.yaml": "graph.yaml",
    "room.yaml": "room.yaml",
}
"""File of a new package -> its template."""
STAGE_FILES: Mapping[str, str] = {
    "followspot_$plugin/$stage.py": "stage.py",
    "tests/test_$stage.py": "test_stage.py",
}


def new_plugin(name: str, where: Path) -> Path:
    """Make the package `followspot-NAME` below a folder; return its folder. Raises InputError."""
    if _PLUGIN_NAME.fullmatch(name) is None or keyword.iskeyword(name):
        raise _wrong(f'"{name}" cannot be the name of a plugin', "one lower-case word, as in: studio")
    if f"{name}." == OFFERED:
        raise _wrong(f'"{name}" names the classes of a script', f"take another, as in: my{name}")
    if name in _taken():
        raise _wrong(f'a plugin "{name}" comes with followspot', f"take another, as in: my{name}")
    folder = where / f"followspot-{name}"
    if folder.exists():
        raise _wrong(f"{folder} exists already", "choose another name or another --dir")
    words = _words(name, _FIRST)
    for target, template in {**PLUGIN_FILES, **STAGE_FILES}.items():
        _write(folder / Template(target).substitute(words), _filled(template, words))
    return folder


def new_stage(
    name: str, package: Path, takes: Sequence[str] = (), gives: str | None = None
) -> tuple[Path, str]:
    """Add a stage to a package; return its module and its full name. Raises InputError.

    takes, gives: types of its messages; without both, it is an example with tracks.
    """
    if _STAGE_NAME.fullmatch(name) is None or keyword.iskeyword(name):
        raise _wrong(f'"{name}" cannot be the name of a stage', "lower-case words joined by _, as in: shout")
    project = package / "pyproject.toml"
    plugin = _plugin_of(project)
    words = _words(plugin, name)
    if words["class_name"] in {*BASES, *message_types()}:
        text = f'the class {words["class_name"]} of a stage "{name}" would hide one of followspot'
        raise _wrong(text, f"take another, as in: {name}_stage")
    texts: tuple[str, ...]
    if takes or gives:
        texts = (stub(words["class_name"], takes, gives), stub_test(plugin, name, words["class_name"]))
    else:
        texts = tuple(_filled(template, words) for template in STAGE_FILES.values())
    paths = (package / Template(target).substitute(words) for target in STAGE_FILES)
    targets = dict(zip(paths, texts, strict=True))
    for target in targets:
        if target.exists():
            raise _wrong(f"{target} exists already", "choose another name")
    text = project.read_text(encoding="utf-8").rstrip() + "\n"
    line = f'"{plugin}.{name}" = "followspot_{plugin}.{name}:{words["class_name"]}"'
    begin = text.index("\n", text.index(GROUP)) + 1
    for target, content in targets.items():
        _write(target, content)
    waiting = project.with_name(f".{project.name}.new")
    _write(waiting, f"{text[:begin]}{line}\n{text[begin:]}")
    waiting.replace(project)
    return package / f"followspot_{plugin}" / f"{name}.py", f"{plugin}.{name}"


def _taken() -> set[str]:
    """First words of stages that come with followspot."""
    ours = {entry.name for entry in catalogue().values() if entry.distribution == "followspot"}
    return {name.partition(".")[0] for name in (*ours, ROOM_SOURCE)}


def _plugin_of(project: Path) -> str:
    """Name of the plugin that a pyproject.toml describes. Raises InputError."""
    try:
        described = tomllib.loads(project.read_text(encoding="utf-8"))
    except FileNotFoundError:
        remedy = "go to the folder that `followspot new plugin` made, or name it with --dir"
        raise _wrong(f"there is no {project}", remedy) from None
    except (OSError, ValueError) as error:
        raise _wrong(f"{project} cannot be read: {error}", "mend it first") from None
    name = str(described.get("project", {}).get("name", ""))
    plugin = name.removeprefix("followspot-")
    if plugin == name or _PLUGIN_NAME.fullmatch(plugin) is None or GROUP not in project.read_text("utf-8"):
        remedy = f"its name begins with followspot- and it has the table {GROUP}"
        raise _wrong(f"{project} is not one that `followspot new plugin` made", remedy)
    return plugin


def _words(plugin: str, stage: str) -> dict[str, str]:
    ours = version("followspot")
    return {
        "plugin": plugin,
        "stage": stage,
        "class_name": "".join(word.capitalize() for word in stage.split("_")),
        "version": ours,
        "next_version": f"{int(ours.split('.')[0]) + 1}",
    }


def _filled(template: str, words: Mapping[str, str]) -> str:
    text = (TEMPLATES / f"{template}.template").read_text(encoding="utf-8")
    return Template(text).substitute(words)


def _write(path: Path, text: str) -> None:
    with writing(path):
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_text(text, encoding="utf-8")


def _wrong(text: str, remedy: str) -> InputError:
    return InputError.of(text, remedy)
