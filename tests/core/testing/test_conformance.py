"""Every installed stage passes the kit; the kit finds what a careless author forgets."""

from __future__ import annotations

import gc
import importlib
import inspect
import os
import subprocess
import sys
from collections.abc import Sequence
from pathlib import Path

import pytest
from tests.core.testing.breaking import effects, inputs, outputs, sources
from tests.stages import rates

from followspot import Field, Source, Stage, StageParams
from followspot.plugins.catalogue import catalogue
from followspot.plugins.registry import load_stage
from followspot.testing import PROMISES, check_stage, findings
from followspot.testing.promises.closing import closes_within_a_second
from followspot.testing.promises.fresh_process import does_the_same_in_a_fresh_process
from followspot.testing.trial import Trial
from followspot.tracking import Blobs, Frame, ImageTracks

SLOW = {
    "persons.pose_tracker": {"particles": 20},
    "persons.appearance": {"particles": 20},
    "persons.uniform_search": {"particles": 100},
    "lsl.outlet": {"host": "0.0.0.0"},  # which it needs
}
"""Parameters that make short work of stages which take tens of milliseconds a message."""
MESSAGES = {
    "persons.pose_tracker": 100,
    "persons.appearance": 100,
    "persons.uniform_search": 100,
    "balls.throws": 2000,
    "dashboard.meter": 10_000,
    "recording.sink": 3000,
}
"""For which the memory of a stage is watched if `ENOUGH` are too slow, or do not fill what it remembers."""
ENOUGH = 390
"""In a third of them, one object that each leaves behind is more than Python keeps for reuse."""


NEEDS = {
    "sinks.rerun": "rerun",
    "filters.kalman_filterpy": "filterpy",
    "cameras.genicam": "viva_genicam",
    "cameras.rtsp": "av",
}
"""Large packages that stages need and machines may lack."""


@pytest.mark.parametrize("name", sorted(catalogue()))
def test_built_in_stage_keeps_every_promise(name: str) -> None:
    if name in NEEDS:
        pytest.importorskip(NEEDS[name])
    check_stage(load_stage(name), messages=MESSAGES.get(name, ENOUGH), **SLOW.get(name, {}))


@pytest.mark.thorough
@pytest.mark.parametrize("name", sorted(name for name in catalogue() if MESSAGES.get(name, ENOUGH) < 2000))
def test_built_in_stage_keeps_every_promise_over_two_thousand_messages(name: str) -> None:
    if name in NEEDS:
        pytest.importorskip(NEEDS[name])
    check_stage(load_stage(name), **SLOW.get(name, {}))


def test_what_the_caller_of_the_kit_has_frozen_stays_so() -> None:
    gc.freeze()
    frozen = gc.get_freeze_count()
    check_stage(load_stage("balls.mean"), messages=30)
    assert gc.get_freeze_count() > frozen // 2, "what ends is not counted any more"


class Careless(Stage):
    class Params(StageParams):
        size: float = Field(-1.0, gt=0, description="")

    def process(self, blobs: Blobs) -> Blobs:
        return blobs


class Raising(Stage):
    """Fails at everything."""

    def process(self, blobs: Blobs) -> Blobs:
        raise ZeroDivisionError


class NotYielding(Stage):
    """Says it is a source."""

    def process(self) -> Source[Blobs]:
        return iter(())


class Estranged(Stage):
    """Says something else together than alone."""

    per_camera = True

    def process(self, frame: Frame) -> ImageTracks:
        return ImageTracks.empty(camera=frame.camera)

    @classmethod
    def process_together(cls, stages: Sequence[Stage], inputs: Sequence[object]) -> list[ImageTracks]:
        return [ImageTracks.empty(camera=[*stage.room.cameras][-1]) for stage in stages]


def test_the_kit_names_each_broken_promise() -> None:
    broken = {finding.promise for finding in findings(Careless)}
    assert broken == {
        "is documented",
        "describes its parameters",
        "states its units",
        "has defaults within its limits",
    }
    assert {f.promise for f in findings(Raising)} >= {
        "leaves empty inputs alone",
        "takes noise",
        "takes a gap",
    }
    assert [f.promise for f in findings(NotYielding)] == ["has readable ports"]
    assert {f.promise for f in findings(Estranged)} == {"does together what it does alone"}
    with pytest.raises(AssertionError, match="write a docstring"):
        check_stage(Careless)


@pytest.mark.parametrize(
    ("stage", "promise"),
    [
        (inputs.Loose, "refuses unknown parameters"),
        (inputs.Loose, "keeps its parameters"),
        (inputs.Writing, "leaves its inputs as they were"),
        (outputs.Reusing, "leaves what it sent alone"),
        (effects.Clocked, "gives the same again"),
        (effects.Drawing, "leaves the random numbers of others alone"),
        (effects.Printing, "prints nothing"),
        (effects.PrintingBytes, "prints nothing"),
        (effects.PrintingBuffered, "prints nothing"),
        (outputs.WrongType, "sends what it declares"),
        (outputs.NoMessage, "sends what it declares"),
        (outputs.Timed, "sends what it declares"),
        (outputs.WrongShape, "sends what it declares"),
        (outputs.Stranger, "sends what it declares"),
        (outputs.EarlyOutputs, "sends what it declares"),
        (outputs.Hasty, "sends what it declares"),
        (outputs.Unending, "sends what it declares"),
        (outputs.LateAnswer, "sends what it declares"),
        (inputs.WindowWriter, "leaves its inputs as they were"),
        (inputs.NotANumber, "takes unknown numbers"),
        (inputs.Late, "takes the same frame twice"),
        (inputs.Late, "takes a late frame"),
        (inputs.SmallPicture, "takes a picture of one pixel"),
        (effects.Hoarding, "keeps its memory"),
        (effects.Threaded, "leaves no thread behind"),
        (effects.Opening, "leaves no file open"),
        (effects.NeedsSetup, "closes without setup"),
        (effects.ObjectState, "has a state of plain values"),
        (effects.Forgetful, "carries on from its state"),
        (sources.Backwards, "never goes back in time"),
        (sources.Misdated, "tells its capture times"),
        (sources.Unsteady, "yields the same again"),
        (sources.Undeclared, "yields what it declares"),
        (sources.Timeless, "yields what it declares"),
        (inputs.Lonely, "leaves empty inputs alone"),
        (inputs.Speechless, "takes plausible inputs"),
        (inputs.Untyped, "has readable ports"),
        (sources.Stubborn, "stops within a second"),
        (sources.HalfTimed, "yields what it declares"),
        (sources.Guessing, "tells its capture times"),
        (effects.Hashing, "does the same in a fresh process"),
        (sources.HashingSource, "does the same in a fresh process"),
    ],
)
def test_a_broken_promise_is_found(stage: type[Stage], promise: str) -> None:
    assert promise in {finding.promise for finding in findings(stage, messages=400)}


@pytest.mark.parametrize(
    "stage", [rates.Gather, rates.Near, rates.Mix, rates.Burst, rates.Later, rates.Behind]
)
def test_stages_with_inputs_and_results_of_all_kinds_keep_every_promise(stage: type[Stage]) -> None:
    check_stage(stage, messages=200)


def test_a_stage_that_holds_up_the_end_is_found() -> None:
    (told,) = closes_within_a_second(Trial(effects.Lingering))
    assert told.startswith("close takes 1.")


def test_a_class_inside_a_function_cannot_be_started_in_a_worker() -> None:
    class Hidden(Stage):
        """Nobody else can import it."""

        def process(self, blobs: Blobs) -> Blobs:
            return blobs

    assert {finding.promise for finding in findings(Hidden, messages=0)} == {"is found by its name"}


def test_a_stage_that_only_this_process_can_import_is_found(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.syspath_prepend(tmp_path)
    for name in ("kept", "gone"):
        (tmp_path / f"{name}.py").write_text(
            f"from {inputs.__name__} import Loose\nclass Own(Loose):\n    pass\n"
        )
    kept, gone = (importlib.import_module(name).Own for name in ("kept", "gone"))
    (tmp_path / "gone.py").write_text("raise OSError('not with me')\n")
    assert not list(does_the_same_in_a_fresh_process(Trial(kept)))
    assert list(does_the_same_in_a_fresh_process(Trial(gone))) == [
        "a fresh process cannot import it: OSError: not with me (gone.py, line 1)"
    ]


def test_hashes_are_others_in_a_fresh_process_although_the_environment_says_which(tmp_path: Path) -> None:
    (tmp_path / "script.py").write_text(
        f"from {effects.__name__} import Hashing\n"
        "from followspot.testing.promises.fresh_process import does_the_same_in_a_fresh_process\n"
        "from followspot.testing.trial import Trial\n"
        "print(len(list(does_the_same_in_a_fresh_process(Trial(Hashing)))))\n"
    )
    done = subprocess.run(
        [sys.executable, str(tmp_path / "script.py")],
        capture_output=True,
        text=True,
        check=True,
        env={**os.environ, "PYTHONPATH": str(Path(__file__).parents[3]), "PYTHONHASHSEED": "7"},
    )
    assert done.stdout == "1\n", done.stderr


def test_a_promise_that_raises_names_the_line_of_the_stage_also_if_a_library_raised_there() -> None:
    line = inspect.getsourcelines(Raising.process)[1] + 1
    assert any(
        finding.text.endswith(f"raise ZeroDivisionError: (test_conformance.py, line {line})")
        for finding in findings(Raising, messages=0)
    )


def test_a_script_without_a_guard_checks_a_stage(tmp_path: Path) -> None:
    (tmp_path / "mine.py").write_text(f"from {inputs.__name__} import Loose\nclass Own(Loose):\n    pass\n")
    script = (
        "from mine import Own\n"
        "from followspot.testing.promises.fresh_process import does_the_same_in_a_fresh_process\n"
        "from followspot.testing.trial import Trial\n"
        "print(list(does_the_same_in_a_fresh_process(Trial(Own))))\n"
    )
    (tmp_path / "script.py").write_text(script)
    path = os.pathsep.join([str(tmp_path), str(Path(__file__).parents[3])])
    words = [sys.executable, str(tmp_path / "script.py")]
    done = subprocess.run(
        words, capture_output=True, text=True, check=True, env={**os.environ, "PYTHONPATH": path}
    )
    assert done.stdout == "[]\n", done.stderr


def test_there_are_at_least_thirty_promises_each_with_a_name_and_a_reason() -> None:
    assert len(set(PROMISES)) >= 30
    assert all(promise.__doc__ for promise in PROMISES)
