"""The page's own files: in wheels and source distributions, never in the repository."""

from __future__ import annotations

import argparse
import asyncio
import shutil
import subprocess
import tarfile
import zipfile
from importlib import import_module
from pathlib import Path

import pytest
from starlette.requests import Request
from tests.packages import build
from tests.tools.page.bundled import ROOT, UNREACHED, bundle

from followspot.errors import InputError
from followspot_page import options
from followspot_page.bundle import check_bundle
from followspot_page.hooks import configure
from followspot_page.http import routes

PAGE = "followspot_page/static"
FILES = {f"{PAGE}/{name}" for name in ("app.js", "icon.svg", "index.html", "style.css", "three.LICENSE")}


def test_a_checkout_without_the_bundle_says_how_to_get_it_on_the_command_line(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(options, "check_bundle", lambda: check_bundle(tmp_path))
    parser = argparse.ArgumentParser()
    configure(parser)
    with pytest.raises(InputError, match="not bundled in this checkout yet: make bundle does it"):
        options.order_of(parser.parse_args(["--dashboard"]))


def test_and_to_a_browser(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(routes, "is_bundled", lambda: False)
    answer = asyncio.run(routes.home(Request({"type": "http"})))
    assert answer.status_code == 503
    assert answer.body == b"the page is not bundled in this checkout yet: make bundle does it\n"


def test_a_wheel_has_the_bundle(tmp_path: Path) -> None:
    bundle()
    with zipfile.ZipFile(build("wheel", ROOT, tmp_path / "wheel")) as wheel:
        assert {name for name in wheel.namelist() if PAGE in name} == FILES


def test_an_editable_install_asks_for_no_node_and_bundles_nothing(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("subprocess.run", None)
    monkeypatch.syspath_prepend(ROOT / "tools" / "building")
    hook, backend = import_module("bundle_hook"), import_module("backend")
    data: dict[str, list[str]] = {"artifacts": []}
    hook.BundleHook(str(tmp_path), {}, None, None, "", "wheel").initialize("editable", data)
    assert data == {"artifacts": []}
    monkeypatch.chdir(ROOT)
    assert backend.NODE not in backend.get_requires_for_build_editable()
    assert backend.NODE in backend.get_requires_for_build_wheel()
    assert backend.NODE in backend.get_requires_for_build_sdist()


@pytest.mark.thorough
def test_an_sdist_has_the_bundle_and_makes_the_same_wheel_without_node(tmp_path: Path) -> None:
    bundle()
    with tarfile.open(build("sdist", ROOT, tmp_path / "sdist")) as sdist:
        sdist.extractall(tmp_path, filter="data")
    (source,) = tmp_path.glob("followspot-*")
    assert (source / "web" / "package-lock.json").exists()
    assert not (source / "web" / "node_modules").exists()
    shutil.rmtree(source / "web")  # nothing is left to bundle from
    with zipfile.ZipFile(build("wheel", source, tmp_path / "wheel")) as wheel:
        assert {name for name in wheel.namelist() if PAGE in name} == FILES


def test_the_pure_parts_of_the_page_do_what_their_own_tests_say() -> None:
    bundle("test")


@pytest.mark.parametrize(("said", "code"), [("npm error code EAI_AGAIN", 3), ("npm error code EUSAGE", 1)])
def test_a_machine_without_npm_says_so_and_only_that(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, said: str, code: int
) -> None:
    monkeypatch.syspath_prepend(ROOT / "tools")
    tool = import_module("bundle")
    monkeypatch.setattr(tool, "WEB", tmp_path)  # nothing is installed
    monkeypatch.setattr(tool, "_npm", lambda *_, **__: subprocess.CompletedProcess([], 1, "", said))
    with pytest.raises(SystemExit) as caught:
        tool.check(["types"])
    assert caught.value.code == (code if code == UNREACHED else f"{said}web: npm ci failed")


def test_nothing_built_is_committed_and_the_lock_file_names_no_host() -> None:
    listed = subprocess.run(["git", "ls-files"], cwd=ROOT, capture_output=True, text=True)
    if listed.returncode:
        pytest.skip("needs the repository")
    files = listed.stdout.split()
    assert not [name for name in files if PAGE in name or "node_modules" in name or ".min." in name]
    for name in ("package-lock.json", "package.json", ".npmrc"):
        assert "://" not in (ROOT / "web" / name).read_text(encoding="utf-8"), name
