"""Packages add commands; one that fails is named in the list and the others serve."""

from __future__ import annotations

import subprocess
import sys
from collections.abc import Iterator
from pathlib import Path

import pytest
from tests.core.plugins.packages import install

from followspot.plugins.loaded_hooks import RESERVED, HookModule, load_hooks

HOOKS = """\
from followspot.plugins.hooks import Command, hookimpl


@hookimpl
def followspot_commands():
    return [Command("tune", lambda parser: None, lambda args: 0)]
"""


@pytest.fixture
def site(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Iterator[Path]:
    """A folder of packages, first on the import path."""
    monkeypatch.syspath_prepend(str(tmp_path))
    load_hooks.cache_clear()
    yield tmp_path
    load_hooks.cache_clear()
    for name in [name for name in sys.modules if name.startswith("zz_")]:
        del sys.modules[name]


def offer(site: Path, name: str, module: str) -> HookModule:
    """Install a package with hooks; what became of it."""
    entries = f"[followspot.hooks.v1]\n{name} = zz_{name}"
    install(site, name, entries, modules={f"zz_{name}.py": module})
    load_hooks.cache_clear()
    return next(found for found in load_hooks().modules if found.name == name)


def titles() -> list[str]:
    return [command.title for command in load_hooks().commands]


def test_the_hooks_of_followspot_itself_are_well() -> None:
    load_hooks.cache_clear()
    assert {
        m.name: m.problem for m in load_hooks().modules if m.distribution == "followspot" and m.problem
    } == {}
    assert {"room import", "calibrate targets", "score"} <= set(titles())


def test_a_package_adds_a_command(site: Path) -> None:
    assert offer(site, "zzkeys", HOOKS).problem == ""
    assert "tune" in titles()


@pytest.mark.parametrize(
    ("module", "said"),
    [
        ("import no_such_package", "ModuleNotFoundError: No module named 'no_such_package'"),
        ("raise SystemExit(1)", "SystemExit: 1"),
        (HOOKS.replace("followspot_commands", "followspot_comands"), "unknown hook 'followspot_comands'"),
        (HOOKS.replace("@hookimpl", ""), "followspot_commands is not marked with @hookimpl"),
        ("x = 1", "the module implements no hook"),
        (HOOKS.replace("return [", "1 / 0; return ["), "ZeroDivisionError: division by zero"),
        (HOOKS.replace('Command("tune"', '("tune"'), "returns something that is no Command"),
        (HOOKS.replace('"tune"', '"run"'), 'command "run" is already offered by followspot'),
        (HOOKS.replace('"tune"', '"score"'), 'command "score" is already offered by score'),
    ],
)
def test_a_module_that_fails_is_one_line_and_the_others_serve(site: Path, module: str, said: str) -> None:
    found = offer(site, "zzkeys", module)
    assert said in found.problem
    assert "\n" not in found.problem
    assert "score" in titles()
    assert titles().count("score") == 1


def test_the_commands_of_followspot_itself_are_reserved() -> None:
    from followspot.cli.parser import CORE

    assert {command.parent or command.name for command in CORE} <= set(RESERVED)


def test_asking_for_help_imports_nothing_heavy() -> None:
    code = (
        "import sys; from followspot.plugins.loaded_hooks import load_hooks; load_hooks();"
        "print([n for n in ('cv2', 'scipy', 'zenoh', 'numpy', 'pydantic', 'yaml') if n in sys.modules])"
    )
    found = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert found.stdout.strip() == "[]"
