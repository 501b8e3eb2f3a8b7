"""Ways to break an input of bytes or text, all from one random number generator."""

from __future__ import annotations

import random
from collections.abc import Sequence

NASTY_INTEGERS = (0, 1, -1, 127, 255, 65_535, 2**31 - 1, 2**31, 2**32, 2**63 - 1, -(2**63), 2**64, 10**30)
NASTY_FLOATS = (0.0, -0.0, 1e-320, 1e308, -1e308, float("inf"), float("-inf"), float("nan"))
NASTY_TEXT = (
    *("", "\0", "../../etc/passwd", "/dev/zero", "**", "a" * 5000, "𝔘\u202e", "\ud800", "0x1f", "null"),
)
NASTY_WORDS = (
    *("[", "]", "{", "}", ": ", "- ", "&a ", "*a", "<<: *a"),
    *("!!python/object/apply:os.system [id]", "? ", "|", ">"),
    *("---\n", "...\n", "%YAML 9.9\n", "\t", "\r", "\0", "'", '"', "#"),
    *(",", ",,,,", ";", "=", "\ufeff", "\u2028"),
    *(
        "1e999",
        "-1e999",
        ".nan",
        ".inf",
        "0x",
        "1_000",
        "99999999999999999999999999",
        "-1",
        "0",
        "null",
        "true",
    ),
    *("[" * 200, "{a: " * 60, "a: &a [*a]", "&x [*x, *x]"),
    *("<!DOCTYPE x [<!ENTITY a 'aa'>]>", "&a;&a;", "${x}"),
)
_BYTES_ADDED = 64


def broken_bytes(data: bytes, rng: random.Random, others: Sequence[bytes] = ()) -> bytes:
    """One to six changes: flipped bits, nasty numbers, cuts, copies, noise, the tail of another input."""
    found = bytearray(data)
    for _ in range(rng.choice((1, 1, 1, 2, 3, 6))):
        place = rng.randrange(len(found) + 1)
        way = rng.randrange(7)
        if way == 0 and place < len(found):
            found[place] ^= 1 << rng.randrange(8)
        elif way == 1 and place < len(found):
            found[place] = rng.choice((0, 1, 0x7F, 0x80, 0xFF, rng.randrange(256)))
        elif way == 2:
            del found[place : place + rng.choice((1, 2, 8, len(found)))]
        elif way == 3:
            found[place:place] = rng.randbytes(rng.randrange(1, _BYTES_ADDED))
        elif way == 4:
            span = rng.choice((1, 2, 4, 8))
            number = rng.choice(NASTY_INTEGERS) % 256**span
            found[place : place + span] = number.to_bytes(span, rng.choice(("little", "big")))
        elif way == 5:
            found[place:place] = found[place : place + rng.randrange(1, 256)]
        elif others:
            other = rng.choice(others)
            found[place:] = other[rng.randrange(len(other) + 1) :]
    return bytes(found)


def broken_text(data: bytes, rng: random.Random, others: Sequence[bytes] = ()) -> bytes:
    """As `broken_bytes`, or with words and lines changed so that the result resembles the original."""
    if rng.random() < 0.3:
        return broken_bytes(data, rng, others)
    lines = data.decode("utf-8", "replace").split("\n")
    for _ in range(rng.choice((1, 1, 2, 4))):
        number = rng.randrange(len(lines))
        line = lines[number]
        place = rng.randrange(len(line) + 1)
        way = rng.randrange(6)
        if way == 0:
            lines[number] = line[:place] + rng.choice(NASTY_WORDS) + line[place:]
        elif way == 1:
            words = line.split(" ")
            words[rng.randrange(len(words))] = rng.choice(NASTY_WORDS)
            lines[number] = " ".join(words)
        elif way == 2 and len(lines) > 1:
            del lines[number]
        elif way == 3:
            lines.insert(rng.randrange(len(lines) + 1), line)
        elif way == 4:
            lines[number] = " " * rng.randrange(1, 9) + line
        else:
            other = rng.randrange(len(lines))
            lines[number], lines[other] = lines[other], line
    return "\n".join(lines).encode("utf-8", "surrogatepass")
