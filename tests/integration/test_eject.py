"""A built-in plugin works unchanged as an external package."""

from __future__ import annotations

import os
import re
import shutil
import subprocess
import sys
import zipfile
from pathlib import Path

import pytest
from tests.tools.page.bundled import bundle

from followspot_new.package import new_plugin

pytest.importorskip("hatchling")
ROOT = Path(__file__).parents[2]
PLUGIN = "followspot_sinks"
STAGES = {
    "csv": "csv_file:CsvFile",
    "console": "console:Console",
    "jsonl": "json_lines:JsonLines",
}
COMPILED = shutil.ignore_patterns("__pycache__", "node_modules")
"""Folders whose files change when a process imports a module for the first time, or that no test needs."""
TESTS = """
import pytest
from followspot.plugins.registry import load_stage
from followspot.testing import check_stage

@pytest.mark.parametrize("name", {names})
def test_every_promise_of_a_stage_is_kept(name: str) -> None:
    check_stage(load_stage("ejected." + name), messages=200)
"""


def installed(project: Path, site: Path) -> None:
    """Build the project's wheel and unpack it on Python's path: that installs a pure wheel."""
    command = [sys.executable, "-m", "hatchling", "build", "-t", "wheel", "-d", str(project / "dist")]
    subprocess.run(command, cwd=project, check=True, capture_output=True)
    (wheel,) = (project / "dist").glob("*.whl")
    with zipfile.ZipFile(wheel) as file:
        file.extractall(site)


def without_the_plugin(where: Path) -> Path:
    """A copy of the project without the plugin, and with the page bundled already."""
    bundle()
    where.mkdir()
    for name in ("README.md", "LICENSE", "core", "plugins", "tools", "web", "graphs"):
        source = ROOT / name
        if source.is_dir():
            shutil.copytree(source, where / name, ignore=COMPILED)
        else:
            shutil.copy(source, where / name)
    shutil.rmtree(where / "plugins" / PLUGIN)
    lines = (ROOT / "pyproject.toml").read_text().splitlines()
    kept = [line for line in lines if not re.match(rf'"[\w.]+" = "{PLUGIN}\.|  "plugins/{PLUGIN}"', line)]
    assert len(lines) - len(kept) > len(STAGES)
    (where / "pyproject.toml").write_text("\n".join(kept))
    return where


def ejected(where: Path) -> Path:
    """A new package that contains the plugin's folder unchanged."""
    package = new_plugin("ejected", where)
    shutil.copytree(ROOT / "plugins" / PLUGIN, package / PLUGIN, ignore=COMPILED)
    project = package / "pyproject.toml"
    entries = "".join(f'"ejected.{name}" = "{PLUGIN}.{place}"\n' for name, place in STAGES.items())
    text = project.read_text().replace("[tool.hatch", f"{entries}\n[tool.hatch", 1)
    project.write_text(text.replace('packages = ["', f'packages = ["{PLUGIN}", "'))
    (package / "tests/test_ejected.py").write_text(TESTS.format(names=list(STAGES)))
    graph = package / "graph.yaml"
    graph.write_text(graph.read_text().replace("sinks.csv", "ejected.csv"))
    return package


class Elsewhere:
    """An environment with followspot, without the plugin's built-in copy, and with the new package."""

    def __init__(self, folder: Path) -> None:
        self.site, self.package = folder / "site", ejected(folder)
        installed(without_the_plugin(folder / "core"), self.site)
        installed(self.package, self.site)

    def python(self, *words: str) -> subprocess.CompletedProcess[str]:
        env = {**os.environ, "PYTHONPATH": str(self.site)}
        command = [sys.executable, "-P", *words]  # not what lies in the working folder, but what is installed
        return subprocess.run(command, cwd=self.package, env=env, capture_output=True, text=True, check=False)


@pytest.fixture(scope="module")
def elsewhere(tmp_path_factory: pytest.TempPathFactory) -> Elsewhere:
    return Elsewhere(tmp_path_factory.mktemp("elsewhere"))


def test_the_stages_are_offered_by_the_new_package_alone(elsewhere: Elsewhere) -> None:
    code = (
        f"import followspot, {PLUGIN}; from followspot.plugins.catalogue import catalogue\n"
        f"print(followspot.__file__, {PLUGIN}.__file__)\n"
        "print(sorted(n for n, e in catalogue().items() if e.distribution == 'followspot-ejected'))\n"
        "print([n for n, e in catalogue().items() if n.startswith('sinks.') or e.state != 'ok'])\n"
    )
    done = elsewhere.python("-c", code)
    files, offered, wrong = done.stdout.splitlines()
    assert all(file.startswith(str(elsewhere.site)) for file in files.split())
    assert offered == str(sorted(f"ejected.{name}" for name in (*STAGES, "low")))
    assert wrong == "[]"


def test_they_keep_their_promises_there(elsewhere: Elsewhere) -> None:
    done = elsewhere.python("-m", "pytest", "-q", "-p", "no:cacheprovider", "tests/test_ejected.py")
    assert f"{len(STAGES)} passed" in done.stdout, done.stdout + done.stderr


def test_a_graph_uses_one_of_them_there(elsewhere: Elsewhere) -> None:
    words = ["run", "graph.yaml", "--frames", "3", "--quiet", "--out", "out"]
    done = elsewhere.python("-m", "followspot.cli.main", *words)
    assert done.returncode == 0, done.stderr
    assert len((elsewhere.package / "out/low.csv").read_text().splitlines()) > 1
