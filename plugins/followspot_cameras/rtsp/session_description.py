"""The video of a session as its description says it (SDP, RFC 8866; RTSP, RFC 2326, appendix C)."""

from __future__ import annotations

import base64
import re
from dataclasses import dataclass
from urllib.parse import urljoin

CODECS = {"H264": "h264", "H265": "hevc"}
"""Names in descriptions, and the decoders'."""
START = b"\0\0\0\1"


class NoVideo(ValueError):
    """A description without a video that can be read; the text says what it has."""


@dataclass(frozen=True)
class Video:
    """codec: decoder; rate: RTP time stamps a second; control: address; parameters: of the codec, Annex B."""

    codec: str
    payload_type: int
    rate: int
    control: str
    parameters: bytes


def video_of(description: str, base: str) -> Video:
    """The first video that can be read. base: address that others are relative to. Raises NoVideo."""
    _, *media = re.split(r"(?m)^m=", description)
    seen = []
    for part in media:
        for number, name, rate in re.findall(
            r"(?m)^a=rtpmap:([0-9]{1,3}) ([^/\s]+)/([1-9][0-9]{0,8})\b", part
        ):
            if name.upper() in CODECS and part.startswith("video"):
                control = re.search(r"(?m)^a=control:(\S+)", part)
                address = _joined(base, control[1] if control else "")
                codec = CODECS[name.upper()]
                return Video(codec, int(number), int(rate), address, _parameters(part))
            seen.append(name)
    raise NoVideo(f"it sends {', '.join(seen) or 'no video'}; H.264 and H.265 can be read")


def _joined(base: str, control: str) -> str:
    if control in ("", "*"):
        return base
    if "://" in control:
        return control
    if "?" not in base:
        return f"{base.rstrip('/')}/{control}"
    try:
        return urljoin(base, control)
    except ValueError:  # the server gave a base that is no address
        return base


def _parameters(part: str) -> bytes:
    """Parameter sets of H.264 and H.265 that stand in the description."""
    found = re.findall(r"sprop-(?:parameter-sets|vps|sps|pps)=([^;\s]+)", part)
    try:
        sets = [base64.b64decode(text) for texts in found for text in texts.split(",") if text]
    except ValueError:  # no letters of base64
        return b""
    return b"".join(START + unit for unit in sets)
