"""What chrony and ptp4l find between two hosts is what `followspot doctor` finds, and hosts in step are ok.

Neither changes a clock of this host. All namespaces have its clock, so a library shifts that of the
programs of one host, chrony's and the agent's alike.
"""

from __future__ import annotations

import re
import shutil
import subprocess
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest
from tests.integration.hosts import Hosts, namespaces_are_permitted
from tests.integration.running import wait_until

HERE, THERE = "desk", "pc-left"
SHIFTING = sorted(Path("/usr/lib").glob("*/faketime/libfaketimeMT.so.1"))
ROUNDED = 0.1
"""Of figures with one decimal, ms."""

pytestmark = [
    pytest.mark.thorough,
    pytest.mark.skipif(not namespaces_are_permitted(), reason="this user may not make network namespaces"),
]


@pytest.fixture
def hosts(tmp_path: Path) -> Iterator[Hosts]:
    with Hosts(tmp_path, (HERE, THERE)) as made:
        yield made


def service(hosts: Hosts, host: str, *words: str, env: dict[str, str] | None = None) -> Path:
    """Start a program on a host; the file that it writes to."""
    written = hosts.folder / f"{host}.log"
    shifted = ["env", *(f"{name}={value}" for name, value in (env or {}).items())]
    with written.open("w") as log:
        command = ["ip", "netns", "exec", hosts.space(host), *shifted, *words]
        process = subprocess.Popen(command, stdout=log, stderr=log, text=True)
    hosts.processes.append(process)
    return written


def host_as_doctor_finds_it(hosts: Hosts) -> str:
    """The line about the other host."""
    process = hosts.start(HERE, "doctor", "--connect", hosts.endpoint(THERE), "--insecure")
    out, errors = process.communicate(timeout=300)
    found = [line for line in out.splitlines() if f"host {THERE}" in line]
    assert found, out + errors
    return found[0]


def chrony(hosts: Hosts, host: str, *directives: str, env: dict[str, str] | None = None) -> None:
    """Start chronyd, which measures and does not touch the clock (-x)."""
    own = hosts.folder / f"chrony-{host}"
    own.mkdir(mode=0o700)
    config = [f"pidfile {own}/pid", "cmdport 0", f"bindcmdaddress {own}/socket", *directives]
    service(hosts, host, "chronyd", "-x", "-d", "-u", "root", *config, env=env)


def tracked(hosts: Hosts) -> float | None:
    """By how much the other host's clock is ahead by chrony, ms; None while it does not know."""
    at = hosts.folder / f"chrony-{HERE}" / "socket"
    asked: Any = subprocess.run(
        ["chronyc", "-h", str(at), "-c", "tracking"], capture_output=True, text=True, check=False
    )
    fields = asked.stdout.strip().split(",")
    known = len(fields) > 4 and fields[1] == hosts.address(THERE)
    return 1000 * float(fields[4]) if known else None


@pytest.mark.skipif(not shutil.which("chronyd"), reason="chrony is not installed")
@pytest.mark.skipif(not SHIFTING, reason="libfaketime is not installed")
@pytest.mark.parametrize(("shift", "way"), [(2.5, "ahead of"), (-1.75, "behind")])
def test_doctor_finds_the_offset_that_chrony_finds(hosts: Hosts, shift: float, way: str) -> None:
    clock = {"LD_PRELOAD": str(SHIFTING[0]), "FAKETIME": f"{shift:+}s", "FAKETIME_DONT_FAKE_MONOTONIC": "1"}
    chrony(hosts, THERE, "local stratum 5", "allow", env=clock)
    chrony(hosts, HERE, f"server {hosts.address(THERE)} iburst minpoll 0 maxpoll 0")
    hosts.agent(THERE, env=clock)
    assert wait_until(lambda: tracked(hosts) is not None, 120.0)
    line = host_as_doctor_finds_it(hosts)
    found = re.search(rf"warning .* its clock is (.+) ms {way} this one, to within (.+) ms", line)
    assert found is not None, line
    offset = tracked(hosts)
    assert offset is not None
    assert abs(abs(offset) - float(found[1])) <= float(found[2]) + ROUNDED
    assert abs(offset - 1000 * shift) < 100


@pytest.mark.skipif(not shutil.which("ptp4l"), reason="linuxptp is not installed")
def test_hosts_that_ptp4l_finds_in_step_are_ok(hosts: Hosts) -> None:
    quick = ["--logAnnounceInterval", "-2", "--logSyncInterval", "-3", "--summary_interval", "-3"]
    for host, part in ((THERE, ["--priority1", "1"]), (HERE, ["-s"])):
        own = ["--uds_address", str(hosts.folder / f"ptp-{host}")]
        words = ["ptp4l", "-i", "eth0", "-S", "-m", "--free_running", "1", *own, *quick, *part]
        log = service(hosts, host, *words)
    hosts.agent(THERE)
    offsets = re.compile(r"master offset +(-?\d+)")
    assert wait_until(lambda: len(offsets.findall(log.read_text())) > 8, 120.0), log.read_text()
    line = host_as_doctor_finds_it(hosts)
    found = re.search(r"ok .* answers within (.+) ms, its clock is (.+) ms off", line)
    assert found is not None, line
    by_ptp = min(abs(int(text)) for text in offsets.findall(log.read_text())) / 1e6
    assert by_ptp < 1.0
    assert abs(float(found[2]) - by_ptp) <= float(found[1]) / 2 + ROUNDED
