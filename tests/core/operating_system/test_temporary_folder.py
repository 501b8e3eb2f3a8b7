"""Folders for sockets and intermediate files: none outlasts its process for long."""

from __future__ import annotations

import subprocess
import sys
import tempfile
from pathlib import Path

import pytest

from followspot.operating_system.temporary_folder import TemporaryFolder

KILLED = """
import os, signal
from followspot.operating_system.temporary_folder import TemporaryFolder

folder = TemporaryFolder("test")
(folder.path / "large").write_text("left behind")
os.kill(os.getpid(), signal.SIGKILL)
"""


FORKED = """
import os, sys
from followspot.operating_system.temporary_folder import TemporaryFolder

folder = TemporaryFolder("test")
if os.fork() == 0:
    sys.exit()
os.wait()
print(folder.path.exists())
"""


@pytest.fixture
def temporary(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    monkeypatch.setenv("TMPDIR", str(tmp_path))
    monkeypatch.setattr(tempfile, "tempdir", None)
    return tmp_path


def test_a_folder_goes_at_the_end_of_its_block(temporary: Path) -> None:
    with TemporaryFolder("test") as folder:
        assert folder.path.parent == temporary
    assert not list(temporary.iterdir())
    folder.close()  # a second time does nothing


def test_the_next_process_removes_what_a_killed_one_left(temporary: Path) -> None:
    subprocess.run([sys.executable, "-c", KILLED], check=False)
    (left,) = temporary.iterdir()
    with TemporaryFolder("test") as folder:
        assert not left.exists()
        assert folder.path.exists()


def test_a_copy_of_the_process_leaves_the_folder_to_it(temporary: Path) -> None:
    done = subprocess.run([sys.executable, "-c", FORKED], capture_output=True, text=True, check=True)
    assert done.stdout == "True\n"
    assert not list(temporary.iterdir())


def test_folders_in_use_and_those_of_others_stay(temporary: Path) -> None:
    """Also one without an owner, which may be about to be locked, and a link to a folder elsewhere."""
    elsewhere = temporary / "elsewhere"
    elsewhere.mkdir()
    (elsewhere / "owner").touch()
    (temporary / "followspot-test-link").symlink_to(elsewhere)
    (temporary / "followspot-test-new").mkdir()
    with TemporaryFolder("test") as first, TemporaryFolder("test") as second:
        assert first.path.exists()
        assert second.path.exists()
    assert {path.name for path in temporary.iterdir()} == {
        "elsewhere",
        "followspot-test-link",
        "followspot-test-new",
    }
    assert (elsewhere / "owner").exists()
