"""A host's own certificate is tried before others refuse it: the error names the file and the remedy."""

from __future__ import annotations

import shutil
import ssl
from datetime import UTC, datetime, timedelta
from pathlib import Path

import pytest

from followspot.errors import FollowspotError
from followspot.security.authority import Authority, create_authority
from followspot.transport.host_registry import read_certificates

NOW = datetime.now(UTC)
PAIR = ("key.pem", "cert.pem")


@pytest.fixture
def authority(tmp_path: Path) -> Authority:
    return create_authority(tmp_path / "certs", NOW - timedelta(days=30))


def error_of(folder: Path) -> str:
    with pytest.raises(FollowspotError) as caught:
        read_certificates(folder)
    return str(caught.value)


def copied(names: tuple[str, ...], start: Path, end: Path) -> None:
    for name in names:
        shutil.copy(start / name, end / name)


def test_a_certificate_that_ended_is_told_though_the_list_of_hosts_is_newer(
    authority: Authority, tmp_path: Path
) -> None:
    folder = authority.add("pc-left", "camera", days=1)
    copied(PAIR, folder, tmp_path)
    Authority(authority.folder, NOW).add("pc-left", "camera", renew=True)
    assert read_certificates(folder).own.name == "pc-left"
    copied(PAIR, tmp_path, folder)  # only the list was copied to the host
    said = error_of(folder)
    assert said.startswith(f"{folder}/cert.pem: certificate has expired")
    assert "followspot certs host pc-left --renew" in said
    assert "set the clock of this host" in said


def test_a_clock_before_the_beginning_of_a_certificate_is_told(authority: Authority) -> None:
    folder = Authority(authority.folder, NOW + timedelta(days=2)).add("pc-left", "camera")
    said = error_of(folder)
    assert said.startswith(f"{folder}/cert.pem: certificate is not yet valid; set the clock of this host")


def test_a_certificate_of_another_host_is_told(authority: Authority) -> None:
    left, right = authority.add("pc-left", "camera"), authority.add("pc-right", "camera")
    copied(PAIR, right, left)
    assert f"{left}/cert.pem is the certificate of pc-right, not of pc-left" in error_of(left)


@pytest.mark.parametrize("names", [PAIR, ("ca.pem",)])
def test_a_certificate_of_another_authority_is_told(
    authority: Authority, tmp_path: Path, names: tuple[str, ...]
) -> None:
    folder = authority.add("pc-left", "camera")
    other = create_authority(tmp_path / "other", NOW).add("pc-left", "camera")
    copied(names, other, folder)
    said = error_of(folder)
    assert f"{folder}/cert.pem: it is not of the authority in {folder}/ca.pem" in said
    assert "copy the whole folder of pc-left again" in said


def test_an_authority_that_is_none_is_named(authority: Authority) -> None:
    folder = authority.add("pc-left", "camera")
    (folder / "ca.pem").write_text("")
    assert f"{folder}/ca.pem is no certificate of an authority" in error_of(folder)


def test_a_key_that_this_user_cannot_read_is_named(
    authority: Authority, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Root can read every file, so the test refuses in the place of the system."""
    folder = authority.add("pc-left", "camera")

    def refuse(*_: object, **__: object) -> None:
        raise PermissionError(13, "Permission denied")

    monkeypatch.setattr(ssl.SSLContext, "load_cert_chain", refuse)
    assert f"this user cannot read {folder}/key.pem or {folder}/cert.pem" in error_of(folder)
