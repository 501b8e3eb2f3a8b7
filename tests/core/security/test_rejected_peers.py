"""Standard output under `RejectedPeers`: lines about rejected peers are counted, others pass."""

from __future__ import annotations

import subprocess
import sys

PROGRAM = """
import os, sys
from followspot.security.rejected_peers import RejectedPeers

before = os.fstat(1)
with RejectedPeers(lambda line: print(line, file=sys.stderr)):
    os.write(1, b"a line of a worker\\n")
    os.write(1, b"WARN zenoh_link_tls::unicast: invalid peer certificate: UnknownIssuer\\n")
    os.write(1, b"WARN zenoh_link_tls::unicast: received fatal alert: DecryptError\\n")
    os.write(1, b"INFO access_control: 1a2b did not match any configured ACL subject\\n")
print(os.path.samestat(before, os.fstat(1)), flush=True)
"""


def test_rejections_are_counted_and_standard_output_is_restored() -> None:
    done = subprocess.run(
        [sys.executable, "-c", PROGRAM], capture_output=True, text=True, timeout=60, check=True
    )
    assert done.stdout.splitlines() == ["a line of a worker", "True"]
    assert "invalid peer certificate: UnknownIssuer" in done.stderr
    assert "peer 1a2b" in done.stderr
    assert done.stderr.splitlines()[-1] == "peers refused: 1 certificate, 1 tls, 1 unlisted"
    assert "a peer: received fatal alert: DecryptError; it does not take the certificate of" in done.stderr
