"""The board of the tests of `calibrate intrinsics`, and the command."""

from pathlib import Path

from followspot.cli.main import main
from followspot_calibrate.boards.board import parse_board

CHARUCO = "charuco:7x5:0.04:DICT_4X4_50"
BOARD = parse_board(CHARUCO)
SIZE = (640, 480)


def intrinsics(folder: Path, *more: str) -> int:
    """Run the command on the room file of a folder; its exit code."""
    room = ["--room", str(folder / "room.yaml")]
    return main(["calibrate", "intrinsics", *room, "--board", CHARUCO, *more])
