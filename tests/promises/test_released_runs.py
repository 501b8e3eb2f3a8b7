"""A run that has ended leaves nothing in the process of a script, however many runs it makes."""

from __future__ import annotations

import gc
from collections import Counter
from contextlib import suppress
from pathlib import Path

import pytest

import followspot as fs
from followspot.stage import Stage

GRAPHS = Path(__file__).parents[2] / "graphs"


def held() -> tuple[int, Counter[str]]:
    """The stages that the process holds, and its open descriptors by kind."""
    gc.collect()
    files: Counter[str] = Counter()
    for file in Path("/proc/self/fd").iterdir():
        with suppress(OSError):  # that of the listing itself
            files[str(file.readlink()).partition(":")[0]] += 1
    return sum(isinstance(thing, Stage) for thing in gc.get_objects()), files


@pytest.mark.parametrize("graph", ["glowballs", "person_panorama"])
@pytest.mark.filterwarnings("ignore::UserWarning")
def test_stages_files_and_memory_of_a_run_are_released(graph: str, tmp_path: Path) -> None:
    def run() -> None:
        with fs.run(GRAPHS / f"{graph}.yaml", frames=2, out=tmp_path) as going:
            assert going.wait().ok

    run()  # what is made once, and stays
    before = held()
    run()
    stages, files = held()
    assert stages == before[0]
    assert files - before[1] == Counter()
