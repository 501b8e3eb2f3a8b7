"""The documents are true: their commands exist, their Python runs, their stages take what is shown."""

from __future__ import annotations

import pkgutil
import re
import shlex
import subprocess
import sys
import tomllib
from pathlib import Path

import msgpack
import numpy as np
import pytest
import yaml
from tests.tools.calibrate.rooms import made_room

from followspot.cli.parser import build_parser
from followspot.graph.compile import compile_graph
from followspot.plugins.registry import load_stage
from followspot.testing import tiny_room
from followspot.tracking import Blobs
from followspot.transport.codec import pack
from followspot_calibrate.triangulation import triangulate

ROOT = Path(__file__).parent.parent
FILES = {page.name: page for page in (ROOT / "README.md", *sorted((ROOT / "docs").rglob("*.md")))}
PAGES = {name: page.read_text() for name, page in FILES.items()}
GRAPHS = ROOT / "graphs"
TRIED_ELSEWHERE = (
    "README.md",
    "cameras.md",
    "composing.md",
    "inertial.md",
    "other_programs.md",
    "pose_nets.md",
    "reference.md",
    "sources.md",
    "tutorial.md",
)
"""Tests of their own try these pages; in the reference `...` stands where a graph says more."""
READY = {"distribution.md": "person_panorama.yaml"}
"""The ready graph that a page speaks of, where it is not the demo's."""
FENCED = re.compile(r"^```(?P<language>\S*)\n(?P<text>.*?)^```$", re.DOTALL | re.MULTILINE)


def blocks(page: str, language: str) -> list[str]:
    return [found["text"] for found in FENCED.finditer(PAGES[page]) if found["language"] == language]


def commands() -> list[tuple[str, str]]:
    """Every followspot command of every page, with continued lines joined."""
    found = []
    for page in PAGES:
        for block in (*blocks(page, "sh"), *blocks(page, "")):
            lines = [line.split(" #")[0].strip() for line in block.replace("\\\n", " ").splitlines()]
            found += [(page, line) for line in lines if line.startswith("followspot ")]
    return found


@pytest.mark.parametrize(("page", "line"), commands())
def test_every_command_shown_is_understood(page: str, line: str) -> None:
    words = shlex.split(line.partition(" > ")[0])[1:]
    args = build_parser(words).parse_args(words)
    assert callable(args.run_command)
    for path in re.findall(r"(?:graphs|docs|tools)/[\w./-]+\.\w+", line):
        assert (ROOT / path).is_file(), path


def test_every_stage_of_the_reference_takes_its_defaults() -> None:
    for block in blocks("reference.md", "yaml"):
        for declared in yaml.safe_load(block).values():
            if "..." not in str(declared):
                load_stage(declared["uses"])()


@pytest.mark.parametrize("page", [p for p in PAGES if blocks(p, "yaml") and p not in TRIED_ELSEWHERE])
def test_every_part_of_a_graph_shown_fits_a_ready_graph(page: str, tmp_path: Path) -> None:
    (tmp_path / "show.mcap").touch()
    for block in blocks(page, "yaml"):
        shown = yaml.safe_load(block)
        part = tmp_path / "part.yaml"
        part.write_text(block)
        if "placement" in shown:
            assert compile_graph(GRAPHS / "glowballs.yaml", placement=part).workers
            continue
        stages = shown.get("stages", shown)
        ready = yaml.safe_load((GRAPHS / READY.get(page, "glowballs.yaml")).read_text())
        part.write_text(yaml.safe_dump({**ready, "stages": ready["stages"] | stages}))
        plan = compile_graph(part, room=GRAPHS / ready["room"])
        assert {stage.group for stage in plan.stages} > stages.keys()


PARTS = [
    b for page in ("composing.md", "cameras.md") for b in blocks(page, "yaml") if b.startswith("# part of")
]


@pytest.mark.parametrize("block", PARTS)
def test_every_part_of_a_room_shown_fits_the_simulated_room(block: str, tmp_path: Path) -> None:
    room = yaml.safe_load((GRAPHS / "rooms" / "simulated.yaml").read_text())
    for section, shown in yaml.safe_load(block).items():
        for name, entry in shown.items():
            old = room.setdefault(section, {}).get(name)
            room[section][name] = {**old, **entry} if old else entry
    (tmp_path / "room.yaml").write_text(yaml.safe_dump(room))
    plan = compile_graph(GRAPHS / "glowballs.yaml", room=str(tmp_path / "room.yaml"))
    assert not [note for note in plan.notes if "tune" in note]


def test_the_graph_and_the_sensors_shown_fit_the_simulated_room(tmp_path: Path) -> None:
    graph, sensors = blocks("inertial.md", "yaml")
    (tmp_path / "ring.csv").write_text("time,gx,gy,gz,ax,ay,az\n")
    room = yaml.safe_load((GRAPHS / "rooms" / "simulated_imu.yaml").read_text())
    room["sensors"] = yaml.safe_load(sensors)["sensors"]
    (tmp_path / "room.yaml").write_text(yaml.safe_dump(room))
    (tmp_path / "graph.yaml").write_text(graph.replace(": graphs/", f": {GRAPHS}/"))
    assert compile_graph(tmp_path / "graph.yaml").warnings == ()
    plan = compile_graph(tmp_path / "graph.yaml", room=tmp_path / "room.yaml")
    assert {"imu/wand", "imu/ring", "orientation/ring"} <= {stage.name for stage in plan.stages}


def test_no_page_shows_python_that_no_test_runs() -> None:
    """Here, in tests of the README, the tutorial, the notebook, sources, and in test_page.py of pose nets."""
    shown = {page for page in PAGES if blocks(page, "python")}
    beside = {"README.md", "calibration.md", "inputs_and_outputs.md", "notebook.md", "plugins.md"}
    assert shown == beside | {"pose_nets.md", "sources.md", "tutorial.md", "wire.md"}


def test_the_decoder_of_the_wire_format_decodes() -> None:
    (recipe,) = blocks("wire.md", "python")
    message = Blobs.empty()
    known = {"data": pack(message), "arrays": {}, "np": np, "msgpack": msgpack}
    exec("import math\n" + recipe, known)  # the page's own words
    assert known["name"] == "Blobs"
    for column, values in known["arrays"].items():  # type: ignore[attr-defined]
        np.testing.assert_array_equal(values, getattr(message, column))


def test_the_page_of_a_calibration_is_made_as_shown(tmp_path: Path) -> None:
    (recipe,) = blocks("calibration.md", "python")
    made = made_room(3, 50)
    found = triangulate(made.cameras, made.sightings.pixel)
    known = {
        "cameras": made.cameras,
        "sightings": made.sightings,
        "points": found.points,
        "residual": found.residual,
        "room": tiny_room(),
        "warnings": [],
        "room_file": tmp_path / "room.yaml",
    }
    exec(recipe, known)  # the page's own words
    assert "Wand of studio" in (tmp_path / "room.wand.html").read_text()


def test_the_tests_shown_to_authors_of_plugins_are_green(tmp_path: Path) -> None:
    package = tmp_path / "followspot_mine"
    package.mkdir()
    (package / "__init__.py").touch()
    stage, *rest = blocks("plugins.md", "python")
    assert stage == blocks("README.md", "python")[0]
    (package / "low.py").write_text(f'"""Keep what is low."""\n\n{stage}')
    (offered,) = tomllib.loads(blocks("plugins.md", "toml")[0])["project"]["entry-points"].values()
    assert offered == {"mine.low": "followspot_mine.low:Low"}
    shown = [*blocks("inputs_and_outputs.md", "python"), *rest]
    (tmp_path / "test_low.py").write_text("\n\n".join(shown))
    words = [sys.executable, "-m", "pytest", "-q", "--import-mode=prepend", tmp_path]
    done = subprocess.run(words, cwd=tmp_path, capture_output=True, text=True, check=False)
    assert "2 passed" in done.stdout, done.stdout + done.stderr


def test_the_reference_describes_the_stages_as_they_are() -> None:
    script = [sys.executable, ROOT / "tools" / "reference.py", "--check"]
    assert subprocess.run(script, check=False).returncode == 0, "stale: run python tools/reference.py"


@pytest.mark.parametrize("page", PAGES)
def test_every_page_that_is_linked_is_there(page: str) -> None:
    for target in re.findall(r"\]\(([\w./-]+)(?:#[\w-]+)?\)", PAGES[page]):
        assert (FILES[page].parent / target).is_file(), target


@pytest.mark.parametrize("page", PAGES)
def test_every_name_of_this_package_that_is_shown_is_there(page: str) -> None:
    for name in re.findall(r"`(followspot(?:_\w+)?(?:\.\w+)+)`", PAGES[page]):
        pkgutil.resolve_name(name)


@pytest.mark.parametrize("page", ["docs/architecture.md", "CONTRIBUTING.md"])
def test_every_file_that_a_page_for_developers_names_is_there(page: str) -> None:
    named = re.findall(r"`([\w/.-]+/[\w.-]*)`", (ROOT / page).read_text())
    assert len(named) > 10
    below = (
        ROOT,
        ROOT / "core/followspot",
        ROOT / "core/followspot/transport",
        ROOT / "core/followspot/host",
    )
    missing = [name for name in named if not any((folder / name).exists() for folder in below)]
    assert missing == []


def test_the_architecture_lists_the_files_at_the_root_of_the_core() -> None:
    """A file that is no API for plugin authors belongs in a folder."""
    section = PAGES["architecture.md"].partition("## Three roles")[2].partition("Everything else")[0]
    listed = re.findall(r"`(\w+\.py)`", section)
    at_root = [path.name for path in (ROOT / "core/followspot").glob("*.py")]
    assert sorted(listed) == sorted({*at_root} - {"__init__.py"})


def test_make_help_lists_every_target() -> None:
    words = ["make", "--no-print-directory", "help"]  # the tests may run under make
    listed = subprocess.run(words, cwd=ROOT, capture_output=True, text=True, check=True).stdout
    (phony,) = re.findall(r"^\.PHONY: (.*)$", (ROOT / "Makefile").read_text(), re.MULTILINE)
    assert [line.split()[0] for line in listed.splitlines()] == phony.split()
