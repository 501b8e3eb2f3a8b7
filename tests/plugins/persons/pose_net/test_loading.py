"""Files of models: those that fit are loaded once, all others are refused with the reason."""

from __future__ import annotations

import gc
import os
import signal
import sys
import weakref
from contextlib import suppress
from pathlib import Path

import numpy as np
import pytest
from tests.plugins.persons.pose_net.tiny_models import TINY_BLAZEPOSE, lit, outside

from followspot import InputError
from followspot.room import Member
from followspot.testing import tiny_room
from followspot_persons.pose_net.blazepose import BlazePose
from followspot_persons.pose_net.loading import decoder_named, network
from followspot_persons.pose_net.movenet import MoveNetMultiPose
from followspot_persons.pose_net.stage import PoseNet
from followspot_persons.pose_net.tflite_file import check_indices

ROWS = np.zeros((6, 56))


def written(folder: Path, name: str, content: bytes) -> Path:
    path = folder / name
    path.write_bytes(content)
    return path


def reason(path: Path, decoder: type = MoveNetMultiPose) -> str:
    with pytest.raises(InputError) as caught:
        network(path, decoder)
    text = str(caught.value)
    assert path.name in text
    return text


def test_stages_share_one_model_until_none_holds_it(tmp_path):
    path = written(tmp_path, "tiny.tflite", TINY_BLAZEPOSE)
    first = network(path, BlazePose)
    assert network(path, BlazePose) is first
    os.utime(path, ns=(1, 1))  # another file may be there now
    assert network(path, BlazePose) is not first
    kept = weakref.ref(first)
    del first
    gc.collect()
    assert kept() is None


@pytest.mark.parametrize("content", [b"", b"\0" * 100, b"not a model" * 1000, TINY_BLAZEPOSE[:1000]])
@pytest.mark.parametrize("suffix", [".tflite", ".onnx"])
def test_bytes_that_are_no_model_are_refused(tmp_path, content, suffix):
    if suffix == ".onnx":
        pytest.importorskip("onnxruntime")
    assert "is no model that BlazePose understands" in reason(
        written(tmp_path, "m" + suffix, content), BlazePose
    )


def test_models_cut_short_or_changed_never_end_the_process(tmp_path):
    rng = np.random.default_rng(3)
    for number in range(30):
        content = bytearray(TINY_BLAZEPOSE)
        for at in rng.integers(0, len(content), 8):
            content[at] = rng.integers(0, 256)
        path = written(tmp_path, f"{number}.tflite", content[: rng.integers(100, len(content) + 1)])
        with suppress(InputError):
            network(path, BlazePose)


class Crashing(BlazePose):
    """Ends its process as a library does that follows an index out of a damaged file."""

    def tensor(self, image):
        os.kill(os.getpid(), signal.SIGSEGV)
        return super().tensor(image)


def test_a_model_that_makes_its_library_crash_is_refused(tmp_path, monkeypatch):
    monkeypatch.setenv("PYTHONPATH", str(Path(__file__).parents[4]))
    told = reason(written(tmp_path, "tiny.tflite", TINY_BLAZEPOSE), Crashing)
    assert "the file is damaged: the process that loads it ends by SIGSEGV" in told


@pytest.mark.parametrize(
    ("at", "said"), [(3672, "it names operator 255 of 2"), (3, "a part lies beyond its end")]
)
def test_indices_that_a_library_follows_blindly_are_checked(at, said):
    check_indices(TINY_BLAZEPOSE)
    content = bytearray(TINY_BLAZEPOSE)
    content[at] = 255
    with pytest.raises(ValueError, match=said):
        check_indices(bytes(content))


@pytest.mark.parametrize("seed", range(20))
def test_any_damage_leaves_the_indices_alone_or_is_told(seed):
    rng = np.random.default_rng(seed)
    for _ in range(50):
        content = bytearray(TINY_BLAZEPOSE)
        for at in rng.integers(0, len(content), 5):
            content[at] = rng.integers(0, 256)
        with suppress(ValueError):
            check_indices(bytes(content[: rng.integers(1, len(content) + 1)]))


def test_a_model_for_another_decoder_is_refused(tmp_path):
    path = written(tmp_path, "tiny.tflite", TINY_BLAZEPOSE)
    assert "MoveNetMultiPose" in reason(path)
    pytest.importorskip("onnxruntime")
    other = written(tmp_path, "other.onnx", lit(np.zeros((6, 51))))
    assert "an output of MoveNet MultiPose is (1, people, 56), not (1, 6, 51)" in reason(other)
    assert "takes" not in reason(written(tmp_path, "movenet.onnx", lit(ROWS)), BlazePose)


@pytest.mark.parametrize("size", [(100_000, 100_000), (64, 4097), (0, 64)])
def test_a_model_for_pictures_that_no_camera_has_is_refused(tmp_path, size):
    pytest.importorskip("onnxruntime")
    told = reason(written(tmp_path, "m.onnx", lit(ROWS, size=size)))
    assert "at most 4096 a side" in told


def test_a_model_reads_no_other_file(tmp_path):
    pytest.importorskip("onnxruntime")
    written(tmp_path, "secret", b"\1" * 4 * 56)
    for location in ("secret", "/etc/hostname", "../" * 8 + "etc/hostname"):
        reason(written(tmp_path, "m.onnx", outside(location)))


def test_what_is_no_file_or_no_model_by_its_name_is_refused(tmp_path):
    assert ".onnx, .tflite" in reason(written(tmp_path, "model.bin", b"x"))
    assert "No such file" in reason(tmp_path / "missing.onnx")
    (tmp_path / "folder.onnx").mkdir()
    assert "understands" in reason(tmp_path / "folder.onnx")
    os.mkfifo(tmp_path / "pipe.onnx")
    assert "not a regular file" in reason(tmp_path / "pipe.onnx")


def test_the_missing_package_is_named_with_the_extra(tmp_path, monkeypatch):
    monkeypatch.setitem(sys.modules, "onnxruntime", None)
    text = reason(written(tmp_path, "m.onnx", lit(ROWS)))
    assert "not installed" in text
    assert "pip install 'followspot[posenet]'" in text
    network(written(tmp_path, "m.tflite", TINY_BLAZEPOSE), BlazePose)  # needs OpenCV alone


def test_an_unknown_decoder_is_told_with_those_that_are_known():
    with pytest.raises(InputError, match='no decoder is called "movenet_multi"') as caught:
        decoder_named("movenet_multi", PoseNet.decoders)
    assert 'did you mean "movenet_multipose"' in str(caught.value)
    assert "blazepose" in str(caught.value)


def test_check_tells_a_model_that_does_not_fit_once(tmp_path):
    path = written(tmp_path, "m.tflite", b"no model")
    params, room = PoseNet.Params(model=path, decoder="blazepose"), tiny_room()
    with pytest.raises(InputError, match="understands"):
        list(PoseNet.check_files(params, room, Member("cameras", "cam0")))
    assert list(PoseNet.check_files(params, room, Member("cameras", "cam1"))) == []
