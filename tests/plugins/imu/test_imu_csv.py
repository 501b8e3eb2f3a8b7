"""Readings from CSV files: units, axes, times, and files that are wrong."""

from __future__ import annotations

import contextlib
import re
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from followspot import Context, InputError, Member
from followspot.csv_rows import FIRST_ROWS
from followspot.inertial import Inertial
from followspot.message_checks.sealing import seal
from followspot.testing import check_stage, tiny_room
from followspot_imu.imu_csv import ImuCsv

HEAD = "time,gx,gy,gz,ax,ay,az"


def imu_csv(path: Path, text: str, warn: Any = print, **params: Any) -> ImuCsv:
    path.write_text(text)
    context = Context("imu", tiny_room(), Member("sensors", "imu0"), warn=warn)
    stage = ImuCsv(context, path=path, **params)
    stage.setup()
    return stage


def messages(path: Path, text: str, **params: Any) -> list[Inertial]:
    stage = imu_csv(path, text, **params)
    sent = [seal(message) for message in stage.process()]
    assert stage.length() == len(sent)
    return sent


def test_readings_come_with_their_times_several_in_a_message(tmp_path: Path) -> None:
    rows = "".join(f"{k / 1000},{k},2,3,4,5,9.8\n" for k in range(25))
    sent = messages(tmp_path / "a.csv", f"{HEAD}\n{rows}", start_time=100)
    assert [len(m.time) for m in sent] == [10, 10, 5]
    assert [m.header.time for m in sent] == [100_009_000_000, 100_019_000_000, 100_024_000_000]
    assert [m.header.time for m in sent] == [m.time[-1] for m in sent]
    assert sent[1].turn_rate[3].tolist() == [13, 2, 3]
    assert sent[1].specific_force[3].tolist() == [4, 5, 9.8]
    assert np.isnan(sent[0].field).all()
    assert sent[0].sensor == "imu0"


def test_units_names_and_axes_of_the_file_are_said(tmp_path: Path) -> None:
    text = "t,sensor,wx,gy,gz,ax,ay,az,mx,my,mz\n1500,imu0,180,0,90,1,0,-2,3,4,5\n1505,imu0,0,0,0,0,0,1,,,\n"
    (sent,) = messages(
        tmp_path / "a.csv",
        text,
        columns={"time": "t", "gx": "wx"},
        time_unit="ms",
        turn_unit="deg/s",
        force_unit="g",
        field_unit="nT",
        axes="y -x z",
        at_rest="down",
    )
    assert sent.time.tolist() == [1_500_000_000, 1_505_000_000]
    np.testing.assert_allclose(sent.turn_rate[0], [0, -np.pi, np.pi / 2])
    np.testing.assert_allclose(sent.specific_force[0], [0, 9.80665, 2 * 9.80665])
    np.testing.assert_allclose(sent.field[0], [0.004, -0.003, 0.005])
    assert np.isnan(sent.field[1]).all()


def test_times_follow_from_the_rate_if_the_file_has_none(tmp_path: Path) -> None:
    text = "gx,gy,gz,ax,ay,az\n" + "0,0,0,0,0,9.8\n" * 4
    (sent,) = messages(tmp_path / "a.csv", text, rate=400, start_time=1)
    assert sent.time.tolist() == [1_000_000_000, 1_002_500_000, 1_005_000_000, 1_007_500_000]


def test_what_sinks_csv_writes_is_read_again(tmp_path: Path) -> None:
    from followspot_sinks.csv_file import CsvFile

    rows = "".join(f"{k / 200},{k % 7},2,{-k},4,0.5,9.8,1,2,3\n" for k in range(30))
    first = messages(tmp_path / "a.csv", f"{HEAD},mx,my,mz\n{rows}")
    sink = CsvFile(Context(room=tiny_room(), out=tmp_path), path="again.csv")
    sink.setup()
    for message in first:
        sink.process((message,))
    sink.close()
    text = (tmp_path / "again.csv").read_text()
    again = messages(tmp_path / "b.csv", text, columns={"time": "reading_time"}, time_unit="ns")
    assert len(again) == len(first) == 15
    for one, other in zip(first, again, strict=True):
        assert one.time.tolist() == other.time.tolist()
        assert np.array_equal(one.specific_force, other.specific_force)
        assert np.array_equal(one.field, other.field)


WRONG = {
    "columns": ("time,gx,gy\n", {}, r"a\.csv:1:1: missing columns: gz, ax, ay, az"),
    "renamed": (HEAD, {"columns": {"gx": "rate_x"}}, r"a\.csv:1:1: missing columns: rate_x"),
    "no such": (HEAD, {"columns": {"gyr": "rate_x"}}, r'there is no column "gyr"'),
    "no time": (HEAD[5:], {}, r"a\.csv:1:1: .* has no column time.*with: \{rate: 100\}"),
    "text": (f"{HEAD}\n0,1,2,x,4,5,6\n", {}, r'a\.csv:2:7: "x" in column gz.*a number'),
    "nan": (f"{HEAD}\n0,1,2,3,4,nan,6\n", {}, r'a\.csv:2:11: "nan" in column ay.*a finite number'),
    "units": (
        f"{HEAD}\n0,1,2,3,4,5,6\n1,1,2,3,9,8,11000\n",
        {},
        r"a\.csv:3:13: .*within 10000; check the units",
    ),
    "degrees": (f"{HEAD}\n0,6000,2,3,4,5,6\n", {"turn_unit": "deg/s"}, r"within 5729\.58; check"),
    "order": (f"{HEAD}\n1,1,2,3,4,5,6\n0,1,2,3,4,5,6\n", {}, r"a\.csv:3:1: time 0 s comes after 1 s.*sort"),
    "twice": (f"{HEAD}\n1,1,2,3,4,5,6\n1,1,2,3,4,5,6\n", {}, r"a\.csv:3:1: time 1 s comes twice.*remove"),
    "time": (f"{HEAD}\n1e99,1,2,3,4,5,6\n", {}, r'a\.csv:2:1: "1e99" in column time.*a time in s'),
    "sensor": (f"{HEAD},sensor\n1,1,2,3,4,5,6,imu1\n", {}, r'a\.csv:2:15: "imu1" in column sensor.*"imu0"'),
    "column twice": (
        f"{HEAD}\n0,1,2,3,4,5,6\n",
        {"columns": {"gx": "gy"}},
        r"a\.csv:1:1: column gy would be read as several.*name each column of the file once",
    ),
    "short": (f"{HEAD}\n1,1,2\n", {}, r"a\.csv:2:1: 3 columns, 7 needed"),
}


@pytest.mark.parametrize(("text", "params", "told"), WRONG.values(), ids=WRONG)
def test_a_wrong_file_is_refused_with_line_and_remedy(
    text: str, params: dict[str, Any], told: str, tmp_path: Path
) -> None:
    with pytest.raises(InputError) as error:
        imu_csv(tmp_path / "a.csv", text, **params)
    assert re.search(told, str(error.value), re.DOTALL), str(error.value)


@pytest.mark.parametrize(("text", "params", "told"), WRONG.values(), ids=WRONG)
def test_check_tells_a_wrong_file_before_a_run(
    text: str, params: dict[str, Any], told: str, tmp_path: Path
) -> None:
    path = tmp_path / "a.csv"
    path.write_text(text)
    for member in (Member("sensors", "imu0"), None):
        with pytest.raises(InputError) as error:
            ImuCsv.check_files(ImuCsv.Params(path=path, **params), tiny_room(), member)
        assert re.search(told, str(error.value), re.DOTALL), str(error.value)


def test_check_reads_the_first_rows_alone(tmp_path: Path) -> None:
    rows = "".join(f"{k},1,2,3,4,5,6\n" for k in range(FIRST_ROWS))
    (tmp_path / "a.csv").write_text(f"{HEAD}\n{rows}what comes later is read by the run\n")
    params = ImuCsv.Params(path=tmp_path / "a.csv")
    assert not ImuCsv.check_files(params, tiny_room(), Member("sensors", "imu0"))


def test_a_file_without_readings_of_the_sensor_is_told(tmp_path: Path) -> None:
    told: list[str] = []
    assert not list(imu_csv(tmp_path / "a.csv", f"{HEAD}\n", warn=told.append).process())
    (text,) = told
    assert text.endswith("a.csv has no readings of sensor imu0")


@pytest.mark.parametrize("axes", ["x y -z", "y x z", "x x z"])
def test_axes_that_no_sensor_has_are_refused(axes: str, tmp_path: Path) -> None:
    with pytest.raises(ValueError, match=r"right-handed|named once"):
        ImuCsv(path=tmp_path / "a.csv", axes=axes)


@given(st.text(st.sampled_from("0123456789.,eE-+\n\"' naNif")))
@settings(max_examples=60, deadline=None)
def test_any_text_gives_readings_or_a_mistake_with_its_place(tmp_path_factory: Any, text: str) -> None:
    path = tmp_path_factory.mktemp("any") / "a.csv"
    with contextlib.suppress(InputError):
        for message in messages(path, f"{HEAD}\n{text}"):
            assert (np.diff(message.time) > 0).all()


def test_the_stage_keeps_every_promise(tmp_path: Path) -> None:
    path = tmp_path / "a.csv"
    path.write_text(HEAD + "\n" + "".join(f"{k / 100},1,2,3,4,5,6\n" for k in range(40)))
    check_stage(ImuCsv, messages=200, path=path)


def rows_at_rest(force: float, turn: float = 0.1) -> str:
    return HEAD + "\n" + "".join(f"{k / 100},{turn},0,0,0,0.1,{force}\n" for k in range(50))


@pytest.mark.parametrize(
    ("text", "params"),
    [(rows_at_rest(1.0), {}), (rows_at_rest(9.8), {"force_unit": "g"}), (rows_at_rest(980.0), {})],
)
def test_a_force_of_another_unit_is_warned_of_by_check_and_run(
    tmp_path: Path, text: str, params: dict[str, Any]
) -> None:
    told: list[str] = []
    stage = imu_csv(tmp_path / "readings.csv", text, told.append, **params)
    (mistake,) = ImuCsv.check_files(stage.params, tiny_room(), Member("sensors", "imu0"))
    assert mistake.warning
    for words in (str(mistake), *told):
        assert "m/s^2 at the median, where a sensor at rest reads 9.8" in words
        assert "force_unit" in words
    assert len(told) == 1


def test_turn_rates_that_no_prop_has_are_warned_of_by_check_and_run(tmp_path: Path) -> None:
    """Degrees of a slow motion, that are within the range of radians."""
    told: list[str] = []
    slow = rows_at_rest(9.8, turn=60.0)
    stage = imu_csv(tmp_path / "readings.csv", slow, told.append)
    (mistake,) = ImuCsv.check_files(stage.params, tiny_room(), Member("sensors", "imu0"))
    assert mistake.warning
    for words in (str(mistake), *told):
        assert "the gyroscope reads 60 rad/s" in words
        assert "turn_unit" in words
    imu_csv(tmp_path / "readings.csv", slow, told.append, turn_unit="deg/s")
    assert len(told) == 1


def test_a_force_of_the_right_unit_is_not_warned_of(tmp_path: Path) -> None:
    told: list[str] = []
    for text, params in (
        (rows_at_rest(9.8), {}),
        (rows_at_rest(1.0), {"force_unit": "g"}),
        (HEAD + "\n", {}),
    ):
        stage = imu_csv(tmp_path / "readings.csv", text, told.append, **params)
        assert not [*ImuCsv.check_files(stage.params, tiny_room(), Member("sensors", "imu0"))]
    assert [text for text in told if "median" in text] == []


def test_degrees_that_are_meant_as_radians_are_refused_with_their_line(tmp_path: Path) -> None:
    with pytest.raises(InputError, match=r"(?s)readings\.csv:2:.*gx"):
        imu_csv(tmp_path / "readings.csv", rows_at_rest(9.8, turn=180.0))
    imu_csv(tmp_path / "readings.csv", rows_at_rest(9.8, turn=180.0), turn_unit="deg/s")


@pytest.mark.parametrize(
    ("gaps", "said"),
    [
        ({}, None),
        ({200: 20_000_000}, None),
        ({200: 3_000_000_000}, "has a gap of 3.01 s without readings after 1.990 s"),
        (
            {200: 1_000_000_000, 300: 2_000_000_000},
            "has 2 gaps, the longest of 2.01 s without readings after 3.990 s",
        ),
    ],
)
def test_gaps_of_a_file_are_told(tmp_path: Path, gaps: dict[int, int], said: str | None) -> None:
    time, rows = 0, []
    for n in range(400):
        time += gaps.get(n, 0)
        rows.append(f"{time},0.1,0,0,0,0,9.8")
        time += 10_000_000
    told: list[str] = []
    text = "\n".join(["time,gx,gy,gz,ax,ay,az", *rows]) + "\n"
    imu_csv(tmp_path / "a.csv", text, told.append, time_unit="ns")
    assert len(told) == (said is not None)
    assert all(said in line for line in told if said)
