"""`Graph`: a graph is composed in a script, with files as stages and classes of this process."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from tests.core.library.scripts import GRAPH, ROOM, Low, composed

import followspot as fs
from followspot.errors import FollowspotError
from followspot.graph.compile import compile_graph
from followspot.graph.plan_data import plan_to_data
from followspot.tracking import Tracks


def test_a_graph_file_is_added_as_a_stage_with_the_arguments_of_its_interface(tmp_path: Path) -> None:
    graph = fs.Graph("two", room=ROOM)
    camera = graph.add("camera", "room.source", each="cameras")
    left = graph.add("left", GRAPH, cameras="cameras[name=cam0|cam1|cam2]", frames=camera, similarity=0.8)
    graph.add("right", Path(GRAPH), frames=camera, tracks_file="right.csv")
    graph.add("low", Low, tracks=left.tracks)
    plan = graph.plan()
    names = {stage.name: stage for stage in plan.stages}
    assert names["left/color/cam0"].params["similarity"] == 0.8
    assert names["right/save"].params["path"] == "right.csv"
    assert not {"left/camera/cam0", "left/color/cam5"} & names.keys()
    assert "left/track.tracks -> low.tracks" in {edge.name for edge in plan.edges}
    assert plan_of(graph.save(tmp_path / "two.yaml")) == plan_of(graph)
    with pytest.raises(fs.FollowspotError, match="no policies of its own"):
        graph.add("third", GRAPH, on_error="skip")
    with pytest.raises(fs.InputError, match="No such file"):
        graph.add("third", "gone.yaml")


def plan_of(graph: fs.Graph | Path) -> list[str]:
    """Instances and edges."""
    plan = graph.plan() if isinstance(graph, fs.Graph) else compile_graph(graph)
    return [*(stage.name for stage in plan.stages), *(edge.name for edge in plan.edges)]


def test_a_composed_graph_is_saved_checked_drawn_and_run_with_a_class_of_this_process(tmp_path: Path) -> None:
    graph = composed()
    assert fs.check(graph, ports=["low"]) == []
    (warning,) = fs.check(graph)
    assert warning.text == 'no stage reads what stage "low" (here.low) gives'
    assert str(graph._repr_svg_()).startswith("<svg")
    with fs.run(graph, frames=15, ports=["low"], out=tmp_path) as run:
        heights = [tracks.xyz[:, 2].max(initial=0.0) for tracks in run["low"]]
    assert len(heights) == 15
    assert max(heights) < 1.2
    with pytest.raises(fs.FollowspotError, match="low: a class of this process cannot run beside"):
        fs.run(graph, placement="camera", out=tmp_path)


def test_a_saved_graph_is_the_same_as_the_composed_one(tmp_path: Path) -> None:
    graph = composed()
    del graph.stages["low"]
    assert plan_to_data(compile_graph(graph.save(tmp_path / "mine.yaml"))) == plan_to_data(graph.plan())


@pytest.mark.parametrize("name", ["hall/left", "x" * 300, "\0"])
def test_a_composed_graph_quotes_itself_in_its_mistakes(name: str) -> None:
    (mistake,) = fs.check(fs.Graph(name))
    assert mistake.text.startswith("graph cannot be")
    graph = fs.Graph("mine")
    graph.add("camera", "cameras.video", path="balls.mp4", speed=3)
    mistakes = [mistake for mistake in fs.check(graph) if "speed" in mistake.text]
    assert str(mistakes[0]).startswith("<Graph mine>:5:")
    assert "speed: 3" in str(mistakes[0])


def test_numbers_of_numpy_are_parameters_and_another_value_is_named() -> None:
    graph = fs.Graph("mine", room=ROOM)
    graph.add("camera", "room.source", each="cameras")
    frame, each = graph.port("camera"), "cameras[kind=color]"
    color = graph.add("color", "balls.color_blobs", each=each, similarity=np.float64(0.9), frame=frame)
    assert "similarity: 0.9" in graph.to_yaml()
    with pytest.raises(FollowspotError, match=r'parameter "tolerance_3d" of stage "fuse" holds a set'):
        graph.add("fuse", "balls.mean_shift", candidates=color.out, tolerance_3d={1, 2})


def test_a_name_that_every_stage_has_is_no_parameter_and_no_input_of_add() -> None:
    with pytest.raises(TypeError, match='no parameter can be named "tolerance": every stage has a key'):

        class Params(fs.StageParams):
            tolerance: float = fs.Field(0.1, description="what `add` would take for that of joins", unit="m")

    class Deep(fs.Stage):
        """An input with the name of an option."""

        def process(self, depth: Tracks) -> None: ...

    graph = fs.Graph("mine", room=ROOM)
    with pytest.raises(FollowspotError, match='"depth" is an option of `add`'):
        graph.add("deep", Deep, depth=graph.port("track.tracks"))  # type: ignore[arg-type]


def test_a_name_or_stage_that_cannot_be_is_refused_by_add() -> None:
    graph = composed()
    with pytest.raises(fs.FollowspotError, match="is there already"):
        graph.add("camera", "room.source")
    with pytest.raises(fs.FollowspotError, match="did you mean"):
        graph.add("other", "balls.mean_shif")


def test_a_misspelt_input_is_told_with_the_right_one() -> None:
    graph = fs.Graph("mine", room=ROOM)
    balls = graph.add("balls", GRAPH)
    graph.add("again", "balls.kalman", positionz=balls.tracks)
    (mistake,) = [m for m in fs.check(graph) if "positionz" in m.text]
    assert "positions" in mistake.remedy


def test_a_type_that_was_defined_again_is_told_from_the_one_that_a_stage_takes() -> None:
    def cell() -> tuple[type[fs.Stage], type[fs.Stage]]:
        class Num(fs.Message):
            value: int

        class Give(fs.Stage):
            def process(self) -> fs.Source[Num]:
                yield fs.at(0, Num(1))

        class Take(fs.Stage):
            def process(self, num: Num) -> None:
                return None

        Give.process.__annotations__["return"] = fs.Source[Num]  # type: ignore[valid-type]
        Take.process.__annotations__["num"] = Num
        return Give, Take

    graph = fs.Graph("cells")
    give = graph.add("give", cell()[0])
    graph.add("take", cell()[1], num=give)
    (mistake,) = fs.check(graph)
    assert mistake.text == '"give" gives Num, but input "num" of stage "take" takes Num'
    assert mistake.remedy == (
        "these are two classes of one name, for Num was defined again: define the stages that use it again, "
        "too; in a notebook, run their cells"
    )


def test_an_unfinished_graph_shows_itself() -> None:
    unfinished = fs.Graph("mine")
    unfinished.add("fuse", "balls.mean_shift")
    assert unfinished._repr_svg_() is None
    assert repr(unfinished) == "<Graph mine: fuse>"


def test_what_is_no_class_is_no_stage() -> None:
    for wrong in (Low(), lambda tracks: tracks):
        with pytest.raises(FollowspotError, match="is no class: a graph makes its stages itself"):
            fs.Graph("wrong").add("low", wrong, tracks="track")  # type: ignore[arg-type]
