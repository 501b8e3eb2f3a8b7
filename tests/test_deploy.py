"""The unit, the images and the workflows start commands that exist; the unit is sound to systemd itself."""

from __future__ import annotations

import re
import shlex
import shutil
import subprocess
import sys
from pathlib import Path
from typing import Any

import pytest
import yaml

from followspot.cli.parser import build_parser
from followspot.graph.compile import compile_graph
from followspot_graphs.shipped import DEMO, graph_file

ROOT = Path(__file__).parents[1]
DEPLOY = ROOT / "deploy"
UNIT = DEPLOY / "followspot-agent@.service"
COMPOSE: dict[str, Any] = yaml.safe_load((DEPLOY / "compose.yaml").read_text())
WORKFLOWS = sorted((ROOT / ".github" / "workflows").glob("*.yaml"))


def composed() -> dict[str, list[str]]:
    """Command lines that the services give to followspot, by service."""
    found = {name: [service["command"]] for name, service in COMPOSE["services"].items()}
    (script,) = found.pop("certificates")[0]
    lines = [line.strip() for line in script.splitlines()]
    return found | {
        "certificates": [line.removeprefix("followspot ") for line in lines if line[:4] == "foll"]
    }


def unit_command() -> str:
    (line,) = re.findall(r"^ExecStart=\S+/followspot (.*)$", UNIT.read_text(), re.MULTILINE)
    return line.replace("%i", "pc-left")


@pytest.mark.parametrize("line", [unit_command(), *(line for lines in composed().values() for line in lines)])
def test_every_command_line_is_understood(line: str) -> None:
    words = shlex.split(line)
    args, unknown = build_parser(words).parse_known_args(words)
    assert not unknown
    assert args.run_command


def test_hosts_have_certificates_and_agents_of_their_names() -> None:
    lines = composed()
    certified = {line.split()[2] for line in lines["certificates"] if line.startswith("certs host ")}
    assert certified == {"desk", "pc-left", "pc-right"} <= set(COMPOSE["services"])
    for name in certified:
        assert COMPOSE["services"][name]["hostname"] == name
        assert f"--certificates /certificates/{name}" in lines[name][0]
    assert re.findall(r"--connect tls/(\S+):7450", lines["desk"][0]) == ["pc-left", "pc-right"]


def test_the_placement_of_the_desk_spreads_the_demo_over_both_hosts(tmp_path: Path) -> None:
    placement = tmp_path / "hosts.yaml"
    placement.write_text(COMPOSE["configs"]["placement"]["content"])
    plan = compile_graph(graph_file(DEMO), placement=placement)
    assert {worker.host for worker in plan.workers} >= {"pc-left", "pc-right"}


def test_the_image_runs_as_a_user_without_rights() -> None:
    image = (DEPLOY / "Dockerfile").read_text()
    last = image[image.rindex("FROM ") :]
    assert last.index("\nUSER followspot\n") < last.index("\nENTRYPOINT ")


@pytest.mark.skipif(not shutil.which("systemd-analyze"), reason="needs systemd-analyze")
def test_systemd_finds_the_unit_sound_and_hardened(tmp_path: Path) -> None:
    unit = tmp_path / UNIT.name
    unit.write_text(UNIT.read_text().replace("/opt/followspot/bin/followspot", sys.executable))
    for words in (["verify", unit], ["security", "--offline=true", "--threshold=25", unit]):
        done = subprocess.run(["systemd-analyze", *map(str, words)], capture_output=True, text=True)
        assert done.returncode == 0, done.stdout + done.stderr


def test_workflows_are_what_github_takes() -> None:
    schema = [sys.executable, "-m", "check_jsonschema", "--builtin-schema", "vendor.github-workflows"]
    done = subprocess.run([*schema, *map(str, WORKFLOWS)], capture_output=True, text=True)
    assert done.returncode == 0, done.stdout + done.stderr


@pytest.mark.parametrize("path", WORKFLOWS, ids=lambda path: path.stem)
def test_workflows_ask_for_no_more_rights_than_they_need(path: Path) -> None:
    workflow = yaml.safe_load(path.read_text())
    assert workflow["permissions"] == {"contents": "read"}
    for name, job in workflow["jobs"].items():
        assert job.get("permissions", {}) == ({"id-token": "write"} if name == "publish" else {})
        assert all(("uses" in step) != ("run" in step) for step in job["steps"])
        taken = [step for step in job["steps"] if step.get("uses", "").startswith("actions/checkout@")]
        assert all(step["with"] == {"persist-credentials": False} for step in taken)
