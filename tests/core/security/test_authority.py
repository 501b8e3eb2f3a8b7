"""The certificate authority: names, permissions of keys, expiry."""

from __future__ import annotations

import json
import os
from datetime import UTC, datetime, timedelta
from pathlib import Path

import pytest
from cryptography import x509
from cryptography.hazmat.primitives.asymmetric import ec
from tests.full_disk import full_disk

from followspot.cli.main import main
from followspot.errors import FollowspotError
from followspot.files import DOCUMENT
from followspot.security.authority import Authority, create_authority
from followspot.transport.host_registry import HostRole, read_certificates, read_host_registry


def mode(path: Path) -> int:
    return path.stat().st_mode & 0o777


@pytest.fixture
def authority(tmp_path: Path) -> Authority:
    return create_authority(tmp_path / "certs")


def test_a_new_authority_is_for_ten_years_on_p256_and_its_key_is_its_owners(authority: Authority) -> None:
    home = authority.folder / "authority"
    certificate = x509.load_pem_x509_certificate((home / "ca.pem").read_bytes())
    key = certificate.public_key()
    assert isinstance(key, ec.EllipticCurvePublicKey)
    assert isinstance(key.curve, ec.SECP256R1)
    assert timedelta(days=3650) <= authority.expires - authority.now < timedelta(days=3654)
    assert mode(home / "key.pem") == 0o600
    assert mode(home) == 0o700


def test_an_authority_is_never_overwritten(authority: Authority) -> None:
    before = (authority.folder / "authority" / "key.pem").read_bytes()
    with pytest.raises(FollowspotError, match="there is an authority"):
        create_authority(authority.folder)
    assert (authority.folder / "authority" / "key.pem").read_bytes() == before


def test_a_hosts_certificate_tells_name_role_and_addresses_and_is_no_authority(authority: Authority) -> None:
    folder = authority.add("pc-left", "camera", ["192.168.0.7", "left.example"])
    certificate = x509.load_pem_x509_certificate((folder / "cert.pem").read_bytes())
    assert certificate.subject.rfc4514_string() == "OU=camera,CN=pc-left"
    names = certificate.extensions.get_extension_for_class(x509.SubjectAlternativeName).value
    assert set(names.get_values_for_type(x509.DNSName)) == {"localhost", "pc-left", "left.example"}
    assert "192.168.0.7" in {str(address) for address in names.get_values_for_type(x509.IPAddress)}
    assert not certificate.extensions.get_extension_for_class(x509.BasicConstraints).value.ca
    assert mode(folder / "key.pem") == 0o600
    root = x509.load_pem_x509_certificate((folder / "ca.pem").read_bytes())
    certificate.verify_directly_issued_by(root)


def test_the_authoritys_key_is_in_no_hosts_folder(authority: Authority) -> None:
    secret = (authority.folder / "authority" / "key.pem").read_bytes()
    folder = authority.add("pc-left", "camera")
    assert all(path.read_bytes() != secret for path in folder.iterdir())


def test_every_registry_lists_every_host(authority: Authority) -> None:
    folders = [authority.add("desk", "operator"), authority.add("pc-left", "camera")]
    for folder in folders:
        own, members = read_host_registry(folder / "hosts.json")
        assert own == folder.name
        assert {(member.name, member.role) for member in members} == {
            ("desk", "operator"),
            ("pc-left", "camera"),
        }


def test_a_removed_host_is_in_no_registry(authority: Authority) -> None:
    desk = authority.add("desk", "operator")
    lost = authority.add("pc-left", "camera")
    authority.remove("pc-left")
    assert [member.name for member in read_certificates(desk).members] == ["desk"]
    assert not lost.exists()


def test_a_taken_name_is_refused_and_renewed_on_request(authority: Authority) -> None:
    folder = authority.add("pc-left", "camera")
    before = (folder / "cert.pem").read_bytes()
    with pytest.raises(FollowspotError, match="--renew"):
        authority.add("pc-left", "camera")
    assert (folder / "cert.pem").read_bytes() == before
    Authority(authority.folder).add("pc-left", "camera", renew=True)
    assert (folder / "cert.pem").read_bytes() != before
    assert mode(folder / "key.pem") == 0o600


@pytest.mark.parametrize(
    "name", ["", "a/b", "../x", ".", "a b", "*", "**", "a$b", "x" * 65, "authority", "hosts.json", "-a"]
)
def test_an_invalid_name_is_refused(authority: Authority, name: str) -> None:
    before = sorted(authority.folder.iterdir())
    with pytest.raises(FollowspotError, match="cannot be the name"):
        authority.add(name, "camera")
    assert sorted(authority.folder.iterdir()) == before


def test_only_operators_have_the_key_of_the_operators_own_ports(authority: Authority) -> None:
    with pytest.raises(FollowspotError, match="choose another name"):
        authority.add("operator", "camera")
    authority.add("operator", "operator")


@pytest.mark.parametrize(
    "address", ["tls/192.168.0.7:7450", "192.168.0.700", "192.168.0", "192.168.0.7.1", "7", "a b", "-a.b", ""]
)
def test_an_invalid_address_is_refused(authority: Authority, address: str) -> None:
    with pytest.raises(FollowspotError, match="neither an IP address nor a host name"):
        authority.add("pc-left", "camera", [address])


def test_addresses_and_names_of_hosts_are_accepted(authority: Authority) -> None:
    authority.add("pc-left", "camera", ["192.168.0.7", "fd00::1", "pc-left", "7up", "0x7.example", "a1.b2"])


def test_a_missing_authority_is_named_with_the_command_that_makes_one(tmp_path: Path) -> None:
    with pytest.raises(FollowspotError, match="followspot certs init"):
        Authority(tmp_path)


def test_an_authority_whose_key_others_can_read_issues_nothing(authority: Authority) -> None:
    (authority.folder / "authority" / "key.pem").chmod(0o644)
    with pytest.raises(FollowspotError, match=r"mode 0644.*chmod 600"):
        Authority(authority.folder)


def test_an_expired_authority_issues_nothing(authority: Authority) -> None:
    with pytest.raises(FollowspotError, match="expired"):
        Authority(authority.folder, datetime.now(UTC) + timedelta(days=3660))


def test_a_certificate_never_outlives_its_authority(tmp_path: Path) -> None:
    old = create_authority(tmp_path / "certs", datetime.now(UTC) - timedelta(days=3600))
    authority = Authority(old.folder)
    authority.add("pc-left", "camera")
    assert authority.members[0].expires <= authority.expires


def test_a_key_that_others_can_read_is_not_used(authority: Authority) -> None:
    folder = authority.add("pc-left", "camera")
    (folder / "key.pem").chmod(0o640)
    with pytest.raises(FollowspotError, match=r"mode 0640.*chmod 600"):
        read_certificates(folder)


@pytest.mark.parametrize("name", ["ca.pem", "cert.pem", "key.pem", "hosts.json"])
def test_a_folder_without_one_of_its_files_is_refused(authority: Authority, name: str) -> None:
    folder = authority.add("pc-left", "camera")
    (folder / name).unlink()
    with pytest.raises(FollowspotError, match=f"{name} is missing"):
        read_certificates(folder)


@pytest.mark.parametrize(
    "text",
    [
        "",
        "[]",
        "{}",
        '{"format": 2, "own": "a", "hosts": {}}',
        '{"format": 1, "own": "a", "hosts": []}',
        '{"format": 1, "own": "a", "hosts": {"a": {"role": "king", "expires": "2030-01-01T00:00Z"}}}',
        '{"format": 1, "own": "a", "hosts": {"**": {"role": "camera", "expires": "2030-01-01T00:00Z"}}}',
        '{"format": 1, "own": "a", "hosts": {"a": {"role": "camera", "expires": "2030-01-01"}}}',
        '{"format": 1, "own": "a", "hosts": {"a": {"role": ["camera"], "expires": 3}}}',
        "[" * 100_000,
        " " * (DOCUMENT + 1),
    ],
)
def test_an_invalid_host_registry_is_refused(tmp_path: Path, text: str) -> None:
    path = tmp_path / "hosts.json"
    path.write_text(text)
    with pytest.raises(FollowspotError, match="no list of hosts"):
        read_host_registry(path)


def test_the_commands_make_show_renew_and_remove(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    folder = ["--dir", str(tmp_path / "certs")]
    assert main(["certs", "init", *folder]) == 0
    assert main(["certs", "host", "desk", "--role", "operator", *folder]) == 0
    assert main(["certs", "host", "pc-left", "--address", "10.0.0.2", *folder]) == 0
    assert "copy it to each host" in capsys.readouterr().out
    assert main(["certs", "show", "--json", *folder]) == 0
    shown = json.loads(capsys.readouterr().out)
    assert {host["name"]: host["role"] for host in shown["hosts"]} == {
        "desk": "operator",
        "pc-left": "camera",
    }
    assert main(["certs", "host", "desk", *folder]) == 1
    assert main(["certs", "host", "desk", "--renew", *folder]) == 0
    assert "desk (operator)" in capsys.readouterr().out
    assert main(["certs", "remove", "pc-left", *folder]) == 0
    assert main(["certs", "remove", "pc-left", *folder]) == 1
    assert "known: desk" in capsys.readouterr().err


def test_no_file_is_readable_by_others_before_its_mode_is_set(authority: Authority) -> None:
    old = os.umask(0)
    try:
        folder = authority.add("pc-left", "camera")
    finally:
        os.umask(old)
    assert mode(folder / "key.pem") == 0o600
    assert mode(folder) == 0o700


def test_a_full_disk_leaves_no_half_authority_and_no_half_host(tmp_path: Path) -> None:
    with full_disk(10), pytest.raises(FollowspotError, match="authority cannot be written: File too large"):
        create_authority(tmp_path / "certs")
    authority = create_authority(tmp_path / "certs")
    with full_disk(10), pytest.raises(FollowspotError, match="desk cannot be written: File too large"):
        authority.add("desk", "operator")
    Authority(tmp_path / "certs").add("desk", "operator")
    assert [member.name for member in Authority(tmp_path / "certs").members] == ["desk"]


def test_a_key_of_another_certificate_is_named(authority: Authority) -> None:
    folder, other = authority.add("pc-left", "camera"), authority.add("pc-right", "camera")
    (folder / "key.pem").write_bytes((other / "key.pem").read_bytes())
    with pytest.raises(FollowspotError, match=r"pc-left/key\.pem is not the key of .*pc-left/cert\.pem"):
        read_certificates(folder)


@pytest.mark.parametrize("role", ["camera", "worker", "operator"])
def test_a_router_needs_a_certificate_of_that_role(
    authority: Authority, role: HostRole, capsys: pytest.CaptureFixture[str]
) -> None:
    """With another one it would listen, and all that it passes on would be refused."""
    folder = authority.add("hub", role)
    assert main(["router", "--listen", "tls/127.0.0.1:0", "--certificates", str(folder)]) == 1
    assert f"the certificate of hub has the role {role}" in capsys.readouterr().err
