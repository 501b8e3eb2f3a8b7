"""`make mutants` chooses the tests that reach a change, and every process of theirs sees the change."""

from __future__ import annotations

import json
import subprocess
from dataclasses import replace
from pathlib import Path

import pytest

from mutation import campaign
from mutation.reach import Reach, choose
from mutation.tree import Mutant, Tree, lay

PATH = "core/followspot/part.py"
CHANGE = Mutant(PATH, "operator", 0, 5, (4, 5), None, "", "VALUE = 2\n")


@pytest.fixture
def tree(tmp_path: Path) -> Tree:
    origin = tmp_path / "origin"
    for name, text in {
        PATH: "VALUE = 1\n",
        "core/followspot/__init__.py": "",
        "core/followspot/testing/fixtures.py": "",
        "tools/mutation/probe.py": Path(campaign.__file__).with_name("probe.py").read_text(),
        "tests/test_part.py": "def test_part() -> None:\n"
        "    from followspot.part import VALUE\n\n    assert VALUE == 1\n",
        "tests/test_child.py": "import subprocess, sys\n\n\ndef test_child() -> None:\n"
        "    code = 'from followspot.part import VALUE; sys.exit(VALUE != 1)'\n"
        "    subprocess.run([sys.executable, '-c', 'import sys; ' + code], env={}, check=True)\n",
        "tests/test_long.py": "def test_long() -> None:\n    from followspot.part import VALUE\n\n"
        "    while VALUE == 2:\n        pass\n",
    }.items():
        (origin / name).parent.mkdir(parents=True, exist_ok=True)
        (origin / name).write_text(text)
    subprocess.run(["git", "init", "-q"], cwd=origin, check=True)
    return lay(origin, tmp_path / "tree")


def reach(file: str, seconds: dict[str, float], lines: dict[int, list[str]], path: str = PATH) -> Reach:
    return Reach(file, "", seconds, [], {path: lines})


@pytest.mark.parametrize("test", ["tests/test_part.py::test_part", "tests/test_child.py::test_child"])
def test_a_change_kills_a_test_in_its_process_and_in_others_and_is_then_gone(tree: Tree, test: str) -> None:
    result = campaign._try(tree, CHANGE, [test], {test: 0.1})
    assert result["killed"] == test
    assert (tree.root / PATH).read_text() == "VALUE = 1\n"
    assert (
        campaign._try(tree, replace(CHANGE, code="VALUE = 1  # same\n"), [test], {test: 0.1})["killed"] == ""
    )


def test_tests_that_are_not_there_tell_nothing_of_a_change(tree: Tree) -> None:
    with pytest.raises(RuntimeError, match=r"not found: .*test_part.py::test_gone"):
        campaign._try(tree, CHANGE, ["tests/test_part.py::test_gone"], {})
    broken = replace(CHANGE, path="tests/test_part.py", code="import nowhere\n")
    result = campaign._try(tree, broken, ["tests/test_part.py::test_part"], {})
    assert result["killed"] == "import"


def test_a_test_that_does_not_end_fails_at_the_second_trial(
    tree: Tree, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(campaign, "AT_LEAST_S", 0.5)
    monkeypatch.setattr(campaign, "PATIENCE", (0.1, 4.0))
    test = "tests/test_long.py::test_long"
    assert campaign._try(tree, CHANGE, [test], {test: 0.0})["killed"] == f"{test} (did not end)"


def test_a_line_is_for_the_tests_that_run_it_and_one_of_a_fixture_for_all_of_the_file() -> None:
    one = reach("tests/test_a.py", {"a": 2.0, "b": 1.0}, {4: ["a"], 9: ["b"]})
    fixture = reach("tests/test_b.py", {"c": 9.0, "d": 3.0}, {5: [""]})
    elsewhere = reach("tests/test_c.py", {"e": 0.1}, {9: ["e"]})
    assert choose([elsewhere, fixture, one], CHANGE, []) == [["a"], ["d", "c"]]


def test_a_line_of_an_import_is_for_the_tests_of_what_it_defines_then_for_those_of_its_importers() -> None:
    defined = reach("tests/test_a.py", {"a": 1.0}, {9: ["a"]})
    importer = reach("tests/test_b.py", {"b": 1.0}, {1: ["b"]}, "core/other.py")
    change = replace(CHANGE, scope=((8, 9),))
    assert choose([defined, importer], change, ["core/other.py"]) == [["a"]]
    assert choose([importer], change, ["core/other.py"]) == [["b"]]


def test_the_tests_of_a_change_stay_within_files_and_seconds() -> None:
    seconds = {"a": 50.0, "b": 8.0, "c": 4.0, "d": 1.0}
    groups = [["a"], ["b", "c"], ["d"]]
    assert campaign._within(groups, seconds, campaign.Limits(files=3, budget_s=10.0)) == ["a"]
    assert campaign._within(groups, seconds, campaign.Limits(files=2, budget_s=60.0)) == ["a", "b"]
    assert campaign._within(groups, seconds, campaign.Limits(files=3, budget_s=60.0)) == ["a", "b", "d"]


def test_the_same_seed_draws_the_same_changes_and_annotations_stay(tmp_path: Path) -> None:
    pytest.importorskip("cosmic_ray", reason="needs the extra 'mutants'")
    from mutation.sites import draw, sites

    code = "def f(a: int | None = 3) -> int | str:\n    g(a)\n    return a + 1 if a > 2 else 0\n"
    (tmp_path / "part.py").write_text(code)
    places = sites(tmp_path, ["part.py"])
    assert {(*place.name.split()[:2], place.line) for place in places} == {
        ("core/NumberReplacer", "22", 1), ("OmitCall", "0", 2), ("core/ReplaceBinaryOperator", "9", 3),
        ("core/NumberReplacer", "11", 3), ("core/ReplaceComparisonOperator", "18", 3),
        ("core/AddNot", "16", 3), ("core/NumberReplacer", "20", 3), ("core/NumberReplacer", "27", 3),
    }  # fmt: skip
    drawn = draw(tmp_path, places, 5, seed=3)
    assert drawn == draw(tmp_path, places, 5, seed=3) != draw(tmp_path, places, 5, seed=4)
    assert all(json.dumps(m.diff) and m.code != code for m in drawn)
    (tmp_path / "part.py").write_text("import g\n\n\nclass A:\n    x = 1\n\n\n" + code)
    edited = [m.diff for m in draw(tmp_path, sites(tmp_path, ["part.py"]), 9, seed=3) if m.line > 5]
    assert edited[:5] == [m.diff for m in drawn], "what stays the same is drawn in the same order"
    (tmp_path / "part.py").write_text(code)
    assert [m.scope for m in draw(tmp_path, places[:1], 1, 0)] == [((2, 3),)]
    (tmp_path / "part.py").write_text("import g\n\n\n@g.plain\nclass A:\n    x = 1\n\n\n" + code)
    assert [m.scope for m in draw(tmp_path, sites(tmp_path, ["part.py"])[:2], 2, 0)] == [((10, 11),)] * 2
