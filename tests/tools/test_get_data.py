"""Data sets are fetched when they are named, go on where they ended, and are what they are said to be."""

from __future__ import annotations

import hashlib
import threading
from collections.abc import Iterator
from http.server import BaseHTTPRequestHandler, ThreadingHTTPServer
from pathlib import Path
from urllib.parse import urlsplit

import pytest

import get_data
from public_data.download import DownloadError, download
from public_data.table import RemoteFile, data_sets

CONTENT = bytes(range(256)) * 1000


class Server(ThreadingHTTPServer):
    """Serves CONTENT. asked: the ranges of the requests; cut: bytes after which an answer breaks off."""

    def __init__(self) -> None:
        super().__init__(("127.0.0.1", 0), Handler)
        self.asked: list[str | None] = []
        self.cut: int | None = None
        self.content, self.ranges = CONTENT, True


class Handler(BaseHTTPRequestHandler):
    server: Server

    def do_GET(self) -> None:
        asked = self.headers["Range"]
        self.server.asked.append(asked)
        begin = int(asked.removeprefix("bytes=").rstrip("-")) if asked and self.server.ranges else 0
        rest = self.server.content[begin:]
        self.send_response(206 if begin else 200)
        self.send_header("Content-Length", str(len(rest)))
        self.end_headers()
        self.wfile.write(rest[: self.server.cut])

    def log_message(self, *_: object) -> None:
        pass


@pytest.fixture
def server() -> Iterator[Server]:
    with Server() as made:
        thread = threading.Thread(target=made.serve_forever)
        thread.start()
        yield made
        made.shutdown()
        thread.join()


def remote(server: Server, size: int = len(CONTENT)) -> RemoteFile:
    url = f"http://127.0.0.1:{server.server_port}/a/video.mp4"
    return RemoteFile("a/video.mp4", url, size, hashlib.sha256(CONTENT).hexdigest())


def test_a_file_comes_whole(server: Server, tmp_path: Path) -> None:
    download(remote(server), tmp_path / "a/video.mp4")
    assert (tmp_path / "a/video.mp4").read_bytes() == CONTENT
    assert [path.name for path in (tmp_path / "a").iterdir()] == ["video.mp4"]


@pytest.mark.parametrize("ranges", [True, False])
def test_a_download_that_was_cut_off_goes_on(server: Server, tmp_path: Path, ranges: bool) -> None:
    server.cut, server.ranges = 1000, ranges
    with pytest.raises(DownloadError, match="try again"):
        download(remote(server), tmp_path / "video.mp4")
    assert not (tmp_path / "video.mp4").exists()
    server.cut = None
    download(remote(server), tmp_path / "video.mp4")
    assert server.asked == [None, "bytes=1000-"]
    assert (tmp_path / "video.mp4").read_bytes() == CONTENT


@pytest.mark.parametrize("other", [b"x" * len(CONTENT), CONTENT + b"x", CONTENT * 2], ids=["same", "1", "2"])
def test_other_bytes_are_refused_and_not_kept(server: Server, tmp_path: Path, other: bytes) -> None:
    server.content = other
    with pytest.raises(DownloadError, match="SHA-256 differs"):
        download(remote(server), tmp_path / "video.mp4")
    assert list(tmp_path.iterdir()) == []


def test_no_server_is_said(tmp_path: Path) -> None:
    with pytest.raises(DownloadError, match="what has come is kept"):
        download(RemoteFile("v", "http://127.0.0.1:9/v", 1, ""), tmp_path / "v")


@pytest.mark.parametrize("path", ["../up", "/etc/passwd", "a/../../up", "a//b", ".hidden", "", "a\\b"])
def test_no_path_leads_out_of_the_folder(path: str) -> None:
    with pytest.raises(ValueError, match="no path below a folder"):
        RemoteFile(path, "http://localhost/", 1, "")


def test_each_set_can_be_fetched_or_says_why_not() -> None:
    known = data_sets()
    for one in known.values():
        assert bool(one.files) != bool(one.by_hand), one.name
        assert all((one.about, one.licence, one.origin)), one.name
        assert not one.files or "BSD" in one.licence or "Apache" in one.licence, one.name
    files = [file for one in known.values() for file in one.files]
    assert {urlsplit(file.url)[:2] for file in files} == {("https", "raw.githubusercontent.com")}
    assert all(len(file.sha256) == 64 and 0 < file.size < 2e7 for file in files)


def test_nothing_is_fetched_that_is_not_named(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert get_data.main(["--to", str(tmp_path)]) == 0
    said = capsys.readouterr().out
    assert "opencv-samples: 8.8 MB to fetch" in said
    assert "balls-thrown-room: by hand" in said
    assert list(tmp_path.iterdir()) == []
    assert get_data.main(["balls-thrown-room", "--to", str(tmp_path)]) == 1
    assert "without a licence" in capsys.readouterr().err
    assert get_data.main(["nothing", "--to", str(tmp_path)]) == 2
    assert "opencv-samples" in capsys.readouterr().err
