"""Files that are no documents, or far too large ones: refused in a moment, with a place, in little memory."""

from __future__ import annotations

import json
import os
import subprocess
import sys
from collections.abc import Callable
from pathlib import Path

import pytest

from followspot.cli.main import main

STAGE = "graph: g\nstages: {a: {uses: sinks.csv}}\n"
CAMERA = (
    "{kind: color, size: [32, 24], matrix: [[9, 0, 9], [0, 9, 9], [0, 0, 1]], translation: [0, 0, 0], "
    "rotation: [[1, 0, 0], [0, 1, 0], [0, 0, 1]], source: {uses: sim.camera}}"
)
MORE_MEMORY = 300 << 20
CPU_S = 60
"""Far more than all files need, and far less than what grows with the square of its length."""
CHILD = f"""
import contextlib, io, json, os, resource, sys
from pathlib import Path
import numpy, cv2, pydantic
from followspot.cli.main import main

taken = int(Path("/proc/self/statm").read_text().split()[0]) * resource.getpagesize()
resource.setrlimit(resource.RLIMIT_AS, (taken + {MORE_MEMORY}, -1))
resource.setrlimit(resource.RLIMIT_CPU, ({CPU_S}, -1))
for folder, *words in json.load(sys.stdin):
    os.chdir(folder)
    said = io.StringIO()
    with contextlib.redirect_stderr(said), contextlib.redirect_stdout(said):
        code = main(["check", *words])
    print(json.dumps([code, said.getvalue()]), flush=True)
"""


def checks(commands: list[list[str]]) -> list[tuple[int, str]]:
    """Exit code and output of `followspot check` for each [FOLDER, ARGUMENT, ...], in one bounded process."""
    done = subprocess.run(
        [sys.executable, "-c", CHILD],
        input=json.dumps(commands),
        capture_output=True,
        text=True,
        timeout=300,
        check=False,
    )
    found = [(code, said) for code, said in map(json.loads, done.stdout.splitlines())]
    assert done.returncode == 0, f"{commands[len(found)]}: {done.stderr[-2000:]}"
    return found


def lines(form: str, count: int) -> str:
    return "".join(form.format(n=n, m=n + 1) for n in range(count))


def endless(path: Path) -> None:
    path.symlink_to("/dev/zero")


def huge(path: Path) -> None:
    with path.open("wb") as file:
        file.truncate(100_000_000)


def own_link(path: Path) -> None:
    path.symlink_to(path.name)


NO_DOCUMENTS: list[tuple[Callable[[Path], None], str]] = [
    (endless, "not a regular file"),
    (os.mkfifo, "not a regular file"),
    (huge, "larger than 1000000 bytes"),
    (own_link, "symbolic links"),
    (os.mkdir, "Is a directory"),
]


def test_what_is_no_document_is_refused_wherever_it_is_named(tmp_path: Path) -> None:
    commands = []
    for make, _ in NO_DOCUMENTS:
        folder = tmp_path / make.__name__
        folder.mkdir()
        make(folder / "odd.yaml")
        make(folder / "odd.py")
        (folder / "good.yaml").write_text(STAGE)
        (folder / "names.yaml").write_text(STAGE + "room: odd.yaml\nextends: ./odd.yaml\n")
        options = ["--room", "odd.yaml", "--placement", "odd.yaml", "--plugin", "odd.py"]
        commands += [
            [str(folder), "odd.yaml"],
            [str(folder), "good.yaml", *options],
            [str(folder), "names.yaml"],
        ]
    found = checks(commands)
    assert {code for code, _ in found} == {2}
    for number, (_, why) in enumerate(NO_DOCUMENTS):
        graph, by_option, by_graph = (said for _, said in found[3 * number : 3 * number + 3])
        assert graph.startswith("odd.yaml:1:1: cannot read odd.yaml: ")
        assert why in graph
        assert by_option.count(why) == 3, by_option
        assert "--room:1:1: " in by_option
        assert "--placement:1:1: " in by_option
        assert by_graph.count(why) == 2
        assert "names.yaml:3:7: cannot read" in by_graph
        assert "names.yaml:4:10: cannot read" in by_graph


LONG = "x" * 300
WRONG = "  s{n}: {{uses: ball.kalmann, foo: 1, in: {{positions: t{m}, x: t{n}}}}}\n"
CASES = {
    "a long base": (f"{STAGE}extends: {LONG}\n", ":3:10: cannot read", "File name too long"),
    "a long room": (f"{STAGE}room: {LONG}\n", ":3:7: cannot read", "File name too long"),
    "a NUL in a name": (f'{STAGE}room: "a\\0b"\n', ":3:7: cannot read", "not a file name"),
    "a long hexadecimal seed": (f"{STAGE}seed: 0x{'f' * 5000}\n", ":3:7: this number", "too many digits"),
    "a long decimal seed": (f"{STAGE}seed: {'9' * 5000}\n", ":3:7: this number", "too many digits"),
    "a seed beyond 64 bits": (f"{STAGE}seed: {2**63}\n", ":3:7: this whole number", "64 bits"),
    "a number beyond all": (f"{STAGE}seed: 1e400\n", ":3:7: this number is too large", "shorten it"),
    "a long text": (f"{STAGE}seed: {'y' * 10_000}\n", ":3:7: this text has more than 4096", "shorten it"),
    "9,000 wrong stages": (
        "graph: g\nstages:\n" + lines("  s{n}: {{uses: ball.kalmann, in: {{x: t{n}}}}}\n", 9000),
        ":1:1: the graph has 9000 stages, at most 1000",
        "more, which are shown when these are mended",
    ),
    "1,000 wrong stages": (
        "graph: g\nstages:\n" + lines(WRONG, 1000),
        ':3:14: no stage "ball.kalmann"',
        'did you mean "balls.kalman"?',
    ),
    "30,000 wrong edges": (
        "graph: g\nstages:\n  a: {uses: sinks.csv, in: {tracks: [" + "stage," * 30_000 + "]}}\n"
        + lines("  stag{n}: {{uses: sinks.csv}}\n", 900),
        ':3:38: there is no stage "stage"',
        "more, which are shown",
    ),
    "aliases of aliases": (
        "a0: &a0 [x]\n" + lines("a{m}: &a{m} [" + ", ".join(["*a{n}"] * 9) + "]\n", 9),
        "the file has more than 100000 values",
        "split the file",
    ),
    "a large mapping that is merged often": (
        "a: &a {" + lines("k{n}: 1, ", 15_000) + "}\nb: &b {x: 1}\nc: {<<: [*a" + ", *b" * 19_000 + "]}",
        'a graph has no key "c"',
        "keys: extends",
    ),
    "a million edges": (
        "graph: g\nstages:\n" + lines("  s{n}: {{uses: balls.kalman, in: {{positions: ["
        + ", ".join(f"s{n}" for n in range(80)) + "]}}}}\n", 1000),
        "the graph has more than 50000 edges",
        "feed fewer inputs",
    ),
    "a hundred stages of a thousand cameras": (
        "graph: g\nroom: cameras.yaml\nstages:\n"
        + lines("  s{n}: {{uses: room.source, each: cameras}}\n", 100),
        "the graph has 100000 stages",
        "at most 10000",
    ),
    "one long line": (
        "graph: g\nstages: {" + lines("s{n}: {{uses: sinks.csw}}, ", 900) + "}",
        ':2:21: no stage "sinks.csw" is installed',
        '^^^^^^^^^ did you mean "sinks.csv"?',
    ),
    "control characters": (
        'graph: g\nstages: {"a\\e[2Jb": {uses: sinks.csv}}',
        r'"a\x1b[2Jb" cannot be the name of a stage',
        "use 1 to 100 letters",
    ),
    "a name that leads elsewhere": (
        STAGE.replace("graph: g", "graph: ../../etc"),
        ':1:8: graph cannot be "../../etc"',
        "a short name without /",
    ),
}  # fmt: skip


MANY_CAMERAS = "cameras:\n" + "".join(f"  c{n}: {CAMERA}\n" for n in range(1000))
PLANNED = "graph: g\nroom: cameras.yaml\nstages:\n  c: {uses: room.source, each: cameras}\n" + lines(
    "  s{n}: {{uses: balls.color_blobs, each: cameras, in: {{frame: c}}}}\n", 8
)


COSTLY = ("9,000 wrong stages", "30,000 wrong edges", "a million edges")
WRONG_STAGES = "graph: g\nstages:\n" + lines(WRONG, 200)


def said_of(folder: Path, texts: list[str], *options: str) -> list[tuple[int, str]]:
    """Exit code and output for each graph."""
    commands = []
    for number, text in enumerate(texts):
        place = folder / str(number)
        place.mkdir()
        (place / "g.yaml").write_text(text)
        (place / "cameras.yaml").write_text(MANY_CAMERAS)
        commands.append([str(place), "g.yaml", *options])
    return checks(commands)


@pytest.fixture(scope="module")
def said(tmp_path_factory: pytest.TempPathFactory) -> dict[str, tuple[int, str]]:
    """Exit code and output for each case that costs little."""
    cases = {case: text for case, (text, _, _) in CASES.items() if case not in COSTLY}
    return dict(zip(cases, said_of(tmp_path_factory.mktemp("cases"), [*cases.values()]), strict=True))


def judge(case: str, code: int, text: str) -> None:
    _, where, what = CASES[case]
    assert code == 2
    assert where in text, text[:2000]
    assert what in text
    assert "\x1b" not in text
    assert len(text) < 50_000


@pytest.mark.parametrize("case", [case for case in CASES if case not in COSTLY])
def test_a_large_or_odd_text_is_refused_and_little_is_said(
    said: dict[str, tuple[int, str]], case: str
) -> None:
    judge(case, *said[case])


@pytest.mark.thorough
@pytest.mark.parametrize("case", COSTLY)
def test_a_very_large_text_is_refused_and_little_is_said(tmp_path: Path, case: str) -> None:
    judge(case, *said_of(tmp_path, [CASES[case][0]])[0])


@pytest.mark.thorough
def test_a_room_of_a_thousand_cameras_is_planned(tmp_path: Path) -> None:
    ((code, text),) = said_of(tmp_path, [PLANNED])
    assert (code, text.splitlines()[0]) == (0, "g in room: 9000 stages, 8000 edges, 1 worker")
    assert 'warning: g.yaml:5:3: no stage reads what stage "s0" (balls.color_blobs) gives' in text


def test_json_names_the_first_mistakes_and_counts_the_rest(tmp_path: Path) -> None:
    ((code, text),) = said_of(tmp_path, [WRONG_STAGES], "--json")
    found = json.loads(text)
    assert (code, found["ok"], len(found["mistakes"]), found["more"]) == (2, False, 50, 750)


def test_options_have_limits_too(tmp_path: Path) -> None:
    (tmp_path / "g.yaml").write_text(STAGE)
    options = ("--set", "a.with." + "x." * 20_000 + "y=1"), ("--room", ""), ("--placement", "x" * 300)
    found = checks([[str(tmp_path), "g.yaml", *words] for words in options])
    assert [code for code, _ in found] == [2, 2, 2]
    assert "is no override" in found[0][1]
    assert "--room:1:1: cannot read" in found[1][1]
    assert "--placement:1:1: cannot read" in found[2][1]


@pytest.mark.parametrize("words", [("--seed", str(2**63)), ("--seed", "-1"), ("--seed", "9" * 5000)])
def test_a_seed_that_no_plan_may_have_is_refused(
    tmp_path: Path, words: tuple[str, str], capsys: pytest.CaptureFixture[str]
) -> None:
    (tmp_path / "g.yaml").write_text(STAGE)
    with pytest.raises(SystemExit) as caught:
        main(["check", str(tmp_path / "g.yaml"), *words])
    assert caught.value.code == 2
    assert "argument --seed: " in capsys.readouterr().err
