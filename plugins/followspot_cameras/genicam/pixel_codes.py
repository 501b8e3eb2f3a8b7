"""Names of pixel formats by their codes (Pixel Format Naming Convention 2.4, table of values)."""

from __future__ import annotations

_TILES = ("GR", "RG", "GB", "BG")
NAMES = {
    0x01080001: "Mono8",
    0x01100003: "Mono10",
    0x010C0004: "Mono10Packed",
    0x01100005: "Mono12",
    0x010C0006: "Mono12Packed",
    0x01100007: "Mono16",
    0x010A0046: "Mono10p",
    0x010C0047: "Mono12p",
    0x02180014: "RGB8",
    0x02180015: "BGR8",
    0x0210001F: "YUV422_8_UYVY",
    0x02100032: "YUV422_8",
    0x0210003B: "YCbCr422_8",
    0x02100043: "YCbCr422_8_CbYCrY",
}
_FIRST = {
    0x01080008: "8",
    0x0110000C: "10",
    0x01100010: "12",
    0x010C0026: "10Packed",
    0x010C002A: "12Packed",
    0x0110002E: "16",
}
"""Code of BayerGR of each kind; RG, GB and BG follow."""
NAMES |= {code + n: f"Bayer{tile}{kind}" for code, kind in _FIRST.items() for n, tile in enumerate(_TILES)}
NAMES |= {0x010A0052 + 2 * n: f"Bayer{tile}10p" for n, tile in enumerate(("BG", "GB", "GR", "RG"))}
NAMES |= {0x010C0053 + 2 * n: f"Bayer{tile}12p" for n, tile in enumerate(("BG", "GB", "GR", "RG"))}


def format_name(code: int) -> str:
    """The name of a code; the code itself if it is not known here."""
    return NAMES.get(code, f"0x{code:08X}")
