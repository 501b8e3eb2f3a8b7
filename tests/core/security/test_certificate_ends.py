"""Certificates that end soon, or have ended."""

from __future__ import annotations

from argparse import Namespace
from datetime import timedelta
from pathlib import Path

import pytest

from followspot.cli.agent_options import network_of
from followspot.errors import FollowspotError
from followspot.security.authority import Authority, create_authority
from followspot.transport.host_registry import expiring_soon, read_certificates


@pytest.fixture
def authority(tmp_path: Path) -> Authority:
    return create_authority(tmp_path / "certs")


def test_a_certificate_that_ends_within_a_month_is_told(
    authority: Authority, capsys: pytest.CaptureFixture[str]
) -> None:
    later = authority.add("pc-right", "camera", days=31)
    folder = authority.add("pc-left", "camera", days=29)
    day = f"{authority.now + timedelta(days=29):%Y-%m-%d}"
    for told in (expiring_soon(folder, authority.now), expiring_soon(folder)):
        assert told.startswith(f"the certificate of pc-left ends on {day}, ")
        assert told.endswith("followspot certs host pc-left --renew")
    assert expiring_soon(later, authority.now) == ""
    assert expiring_soon(folder, authority.now + timedelta(days=30)) == ""  # an error says that
    assert expiring_soon(authority.folder / "none") == ""  # so it does here
    for chosen in (folder, later, authority.folder / "none"):
        network_of(Namespace(listen=[], connect=[], certificates=str(chosen), insecure=False))
    assert capsys.readouterr().err == f"warning: {told}\n"


def test_an_expired_certificate_is_named_with_the_day_and_the_remedy(authority: Authority) -> None:
    folder = authority.add("pc-left", "camera", days=30)
    read_certificates(folder, authority.now + timedelta(days=29))
    with pytest.raises(FollowspotError, match=r"pc-left .* expired on 20.*--renew"):
        read_certificates(folder, authority.now + timedelta(days=31))
