"""The documents claim what tests show: each claim stands where it is said to, and its test is there."""

from __future__ import annotations

import json
import re
import subprocess
import sys
import tomllib
from pathlib import Path

import pytest

from followspot.security.authority import create_authority

ROOT = Path(__file__).parent.parent
SECTIONS = {
    "README": ("README.md",),
    "Who gets in": ("docs/security.md",),
    "Several hosts": ("docs/distribution.md", "docs/faults.md", "docs/changing_runs.md"),
    "The rest": ("docs/is_and_is_not.md", "docs/design.md"),
}
"""The pages that a section of the claims is about."""
FIGURE = re.compile(r"\b\d+(?:\.\d+)?\b")
NO_CLAIMS = ("Jin & Qian 2008", "EURASIP", "Apache-2.0")
"""What has figures and promises nothing."""


def plain(text: str) -> str:
    return " ".join(text.split())


def rows() -> list[tuple[str, str, str]]:
    """Section, sentence and evidence of each claim."""
    found, section = [], ""
    for line in (ROOT / "docs" / "claims.md").read_text().splitlines():
        if line.startswith("## "):
            section = line.removeprefix("## ")
        elif line.startswith("| ") and not line.startswith("| sentence"):
            sentence, evidence = line.strip("| ").split(" | ")
            found.append((section, sentence, evidence))
    return found


ROWS = rows()


def test_every_section_has_claims() -> None:
    assert {section for section, _, _ in ROWS} == set(SECTIONS)
    assert all(sentence and evidence for _, sentence, evidence in ROWS)
    assert len({(section, sentence) for section, sentence, _ in ROWS}) == len(ROWS)


@pytest.mark.parametrize(
    ("section", "sentence", "evidence"), ROWS, ids=[sentence[:40] for _, sentence, _ in ROWS]
)
def test_a_claim_stands_where_it_is_said_to_and_its_test_is_there(
    section: str, sentence: str, evidence: str
) -> None:
    text = " ".join(plain((ROOT / page).read_text()) for page in SECTIONS[section])
    assert plain(sentence) in text, f"{SECTIONS[section]} say so no more: change docs/claims.md as well"
    tests = re.findall(r"`((?:tests|\.ci)/[^`]+)`", evidence)
    assert tests or evidence.startswith("measured")
    for test in tests:
        file, _, name = test.partition("::")
        code = (ROOT / file).read_text()
        assert not name or f"\ndef {name}(" in code, f"{test} is not there: name another in docs/claims.md"
    for tool in re.findall(r"`python (tools/\S+)`", evidence):
        assert (ROOT / tool).is_file()


def test_marks_of_thorough_tests_and_of_recordings_are_those_of_the_tests() -> None:
    for _, _, evidence in ROWS:
        for test, marks in re.findall(r"`(tests/[^`]+::[^`]+)`((?: [†‡])*)", evidence):
            file, _, name = test.partition("::")
            code = (ROOT / file).read_text()
            before = code[: code.index(f"\ndef {name}(")].rpartition("\n\n")[2]
            assert ("†" in marks) == ("@pytest.mark.thorough" in before), test
            needs_data = "@needs_" in before or re.search(
                r"^(pytestmark =|   ) needs_data\(", code, re.MULTILINE
            )
            assert ("‡" in marks) == bool(needs_data), test


def test_no_figure_stands_in_the_readme_without_a_claim() -> None:
    """In its sentences; what code blocks and tables of commands show is tried by other tests."""
    text = re.sub(r"```.*?```", "", (ROOT / "README.md").read_text(), flags=re.DOTALL)
    prose = [line for line in text.splitlines() if not line.startswith(("|", "!["))]
    whole = plain("\n".join(line for line in prose if not any(word in line for word in NO_CLAIMS)))
    claimed = [plain(sentence) for section, sentence, _ in ROWS if section == "README"]
    for sentence in sorted(claimed, key=len, reverse=True):
        whole = whole.replace(sentence, "")
    assert FIGURE.findall(re.sub(r"`[^`]*`", "", whole)) == []


def test_python_and_system_are_those_that_are_declared() -> None:
    project = tomllib.loads((ROOT / "pyproject.toml").read_text())["project"]
    assert project["requires-python"] == ">=3.11"
    assert "Operating System :: POSIX :: Linux" in project["classifiers"]
    assert not [c for c in project["classifiers"] if "Windows" in c or "MacOS" in c or "OS Independent" in c]


RUN = """
import json, os, socket, sys
from followspot.cli.main import main
opened = []
whole = socket.socket.__init__
def noted(self, family=-1, *args, **named):
    opened.append(int(family))
    whole(self, family, *args, **named)
socket.socket.__init__ = noted
code = main(["run", {graph!r}, "--frames", "2", "--quiet", "--out", {out!r}])
print(json.dumps([code, "zenoh" in sys.modules, sorted(set(opened) & {{socket.AF_INET, socket.AF_INET6}})]))
"""


def test_a_plain_run_opens_no_network(tmp_path: Path) -> None:
    program = RUN.format(graph=str(ROOT / "graphs/glowballs.yaml"), out=str(tmp_path))
    done = subprocess.run([sys.executable, "-c", program], capture_output=True, text=True, check=True)
    assert json.loads(done.stdout.splitlines()[-1]) == [0, False, []]


SESSION = """
import sys
sys.modules["cryptography"] = None  # as where it is not installed
from followspot.transport.zenoh.network import Network
from followspot.transport.zenoh.session import connected, locators
session = connected(Network(listen=("tls/127.0.0.1:0",), certificates={certificates!r}))
print(locators(session))
session.close()
"""


def test_certificates_are_used_without_the_package_that_makes_them(tmp_path: Path) -> None:
    folder = create_authority(tmp_path / "certs").add("pc-left", "camera", [])
    program = SESSION.format(certificates=str(folder))
    done = subprocess.run([sys.executable, "-c", program], capture_output=True, text=True, check=False)
    assert done.stdout.startswith("['tls/127.0.0.1:"), done.stderr
