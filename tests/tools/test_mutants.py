"""`make mutants` chooses the tests that reach a change, and every process of theirs sees the change."""

from __future__ import annotations

import subprocess
from pathlib import Path

import pytest

from mutation.campaign import within
from mutation.reach import Reach
from mutation.tree import lay

PATH = "core/followspot/part.py"
PART = """def value() -> int:
    note()
    return 1


def note() -> None:
    NOTES.append(1)


NOTES: list[int] = []
"""
TESTS = {
    "tests/test_part.py": "from followspot.part import NOTES, value\n\n\n"
    "def test_value() -> None:\n    assert value() == 1\n\n\n"
    "def test_note() -> None:\n    before = len(NOTES)\n    value()\n    assert len(NOTES) > before\n",
    "tests/test_child.py": "import subprocess, sys\n\n\ndef test_child() -> None:\n"
    "    code = 'from followspot.part import value; sys.exit(value() != 1)'\n"
    "    subprocess.run([sys.executable, '-c', 'import sys; ' + code], env={}, check=True)\n",
}


@pytest.fixture
def tree(tmp_path: Path) -> Path:
    """The root of a copy of a small tree."""
    origin = tmp_path / "origin"
    files = {PATH: PART, "core/followspot/__init__.py": "", "core/followspot/testing/fixtures.py": ""} | TESTS
    for name, text in files.items():
        (origin / name).parent.mkdir(parents=True, exist_ok=True)
        (origin / name).write_text(text)
    subprocess.run(["git", "init", "-q"], cwd=origin, check=True)
    lay(origin, tmp_path / "tree")
    return tmp_path / "tree"


@pytest.mark.parametrize("test", sorted(TESTS))
def test_a_change_fails_a_test_in_its_process_and_in_others_and_is_gone_in_the_next_copy(
    tree: Path, test: str
) -> None:
    run = [tree / ".venv/bin/python", "-B", "-m", "pytest", "-q", "-p", "no:cacheprovider", test]
    assert subprocess.run(run, cwd=tree, check=False).returncode == 0
    (tree / PATH).write_text(PART.replace("return 1", "return 20"))
    assert subprocess.run(run, cwd=tree, check=False).returncode == 1
    lay(tree.parent / "origin", tree)
    assert (tree / PATH).read_text() == PART


def test_a_line_is_for_the_tests_that_run_it_and_one_of_an_import_for_all_of_its_module() -> None:
    seconds = {"tests/test_a.py::x": 2.0, "tests/test_a.py::y": 1.0, "tests/test_part.py::z": 9.0}
    near, far = "tests/test_part.py::z", "tests/test_a.py::x"
    reach = Reach(seconds, {PATH: {4: {far}, 5: {far, near}, 9: {"tests/test_a.py::y"}}})
    assert reach.tests(PATH, 4, 5) == [near, far]
    assert reach.tests(PATH, 1, 1) == [near, "tests/test_a.py::y", far]
    assert reach.tests("core/other.py", 1, 1) == []


def test_the_tests_of_a_change_stay_within_the_budget_but_for_the_first() -> None:
    reach = Reach({"a": 50.0, "b": 8.0, "c": 4.0}, {})
    assert within(["a", "b", "c"], reach, 10.0) == ["a"]
    assert within(["a", "b", "c"], reach, 60.0) == ["a", "b"]
    assert within([], reach, 60.0) == []


def test_coverage_by_test_tells_which_tests_run_a_line(tree: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.delenv("PYTEST_CURRENT_TEST")  # of this test
    pytest.importorskip("pytest_cov", reason="needs the extra 'mutants'")
    from mutation.reach import measure

    reach = measure(tree, tree / ".venv/bin/python", tree / "store", ["tests"])
    assert set(reach.tests(PATH, 3, 3)) >= {"tests/test_part.py::test_value", "tests/test_part.py::test_note"}
    assert len(reach.seconds) == 3
    assert measure(tree, tree / "nowhere", tree / "store", ["tests"]) == reach, "it is measured once"


def test_the_same_seed_draws_the_same_changes_and_annotations_stay(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    pytest.importorskip("cosmic_ray", reason="needs the extra 'mutants'")
    from mutation.sites import draw

    code = "def f(a: int | None = 3) -> int | str:\n    g(a)\n    return a + 1 if a > 2 else 0\n"
    monkeypatch.chdir(tmp_path)
    part = Path("part.py")
    part.write_text(code)
    drawn = [item.mutations[0] for item in draw([part], 99, seed=3)]
    assert {(one.operator_name.split("_")[0], one.start_pos) for one in drawn} == {
        ("core/NumberReplacer", (1, 22)), ("omit/call", (2, 4)), ("core/ReplaceBinaryOperator", (3, 13)),
        ("core/NumberReplacer", (3, 15)), ("core/ReplaceComparisonOperator", (3, 22)),
        ("core/AddNot", (3, 20)), ("core/NumberReplacer", (3, 24)), ("core/NumberReplacer", (3, 31)),
    }  # fmt: skip
    assert draw([part], 5, seed=3) == draw([part], 5, seed=3) != draw([part], 5, seed=4)
    part.write_text("import g\n\n\nx = 1\n\n\n" + code)
    moved = [item.mutations[0] for item in draw([part], 99, seed=3)]
    kept = [(one.operator_name, one.start_pos[0] - 6) for one in moved if one.start_pos[0] > 4]
    assert kept == [(one.operator_name, one.start_pos[0]) for one in drawn], (
        "what stays is drawn in its order"
    )
