"""Damage, by one seeded generator: bytes, numbers in texts, JSON inside files, members of archives, headers of arrays."""

from __future__ import annotations

import io
import json
import re
import struct
import warnings
import zipfile
from collections.abc import Callable, Sequence

import numpy as np

__all__ = ["mutated"]

_INTEGERS = (0, 1, -1, 2, 127, 128, 255, 256, 32767, 32768, 65535, 2**31 - 1, 2**31, 2**32 - 1, 2**63 - 1, 2**64 - 1)
_NUMBERS = (
    "0", "-1", "1e999", "-1e999", "nan", "inf", "1e-999", "1e99999999", "9" * 30, "9" * 5000, "0.1", "1/0", "", "-", "0x10",
    "4294967296", "1e308", "٣", "1_000", "true", "null", "100000000", "-0",
)  # fmt: skip
_WORDS = (
    b"../../etc/passwd", b"/dev/zero", b"file:///etc/passwd", b"http://127.0.0.1:9/x", b"\xff\xfe", b"\0", b"\r\n", b"<!--",
    b"]]>", b"&x;", b"%s%n", b"\xc3", b"\xf0\x9f\x91\x84", b"{{", b"[[[[", b"(((((", b'"', b"'", b";", b",", b"\t", b"#", b"$",
)  # fmt: skip
_NUMBER = re.compile(rb"-?\d+(?:\.\d+)?(?:[eE][-+]?\d+)?")
_STRANGE = (None, True, -1, 0, 1, 1e308, 2**31, 2**53, "", "x", "../x", "data:;base64,AAAA", [], {}, [[]], 0.5, 10**12)
Random = np.random.Generator
Change = Callable[[bytes, Random, Sequence[bytes]], bytes]


def mutated(content: bytes, random: Random, others: Sequence[bytes]) -> bytes:
    """A file with one to six pieces of damage.

    Parameters
    ----------
    content : bytes
        A sound file.
    random : numpy.random.Generator
    others : sequence of bytes
        Further files of the kind, to take pieces from.
    """
    for _ in range(int(random.integers(1, 7)) if random.random() < 0.7 else 1):
        content = _one(content, random, others)[:5_000_000]
    return content


def _one(content: bytes, random: Random, others: Sequence[bytes]) -> bytes:
    if content[:2] == b"PK" and random.random() < 0.8:
        return _archive(content, random, others)
    if content[:6] == b"\x93NUMPY" and len(content) >= 10 and random.random() < 0.6:
        return _array_header(content, random)
    if content[:4] == b"glTF" and random.random() < 0.7:
        return _glb(content, random)
    if content.lstrip()[:1] in (b"{", b"[") and random.random() < 0.6:
        return _json(content, random)
    text = b"\0" not in content[:2000]
    changes = (*_ON_BYTES, *_ON_TEXT, *_ON_TEXT) if text else _ON_BYTES
    return changes[int(random.integers(len(changes)))](content, random, others)


def _place(content: bytes, random: Random) -> int:
    """Somewhere, more often near the start, where headers are."""
    size = max(1, len(content))
    return int(random.integers(min(size, 400) if random.random() < 0.5 else size))


def _flip(content: bytes, random: Random, others: Sequence[bytes]) -> bytes:
    changed = bytearray(content or b"\0")
    changed[_place(content, random)] ^= 1 << int(random.integers(8))
    return bytes(changed)


def _noise(content: bytes, random: Random, others: Sequence[bytes]) -> bytes:
    at = _place(content, random)
    piece = random.bytes(int(random.integers(1, 30)))
    return content[:at] + piece + content[at + (len(piece) if random.random() < 0.7 else 0) :]


def _integer(content: bytes, random: Random, others: Sequence[bytes]) -> bytes:
    at, size = _place(content, random), int(random.choice([1, 2, 4, 8]))
    value = _INTEGERS[int(random.integers(len(_INTEGERS)))] & (2 ** (8 * size) - 1)
    return content[:at] + value.to_bytes(size, "little" if random.random() < 0.7 else "big") + content[at + size :]


def _cut(content: bytes, random: Random, others: Sequence[bytes]) -> bytes:
    return content[: _place(content, random)]


def _remove(content: bytes, random: Random, others: Sequence[bytes]) -> bytes:
    at = _place(content, random)
    return content[:at] + content[at + int(random.integers(1, 200)) :]


def _repeat(content: bytes, random: Random, others: Sequence[bytes]) -> bytes:
    at = _place(content, random)
    piece = content[at : at + int(random.integers(1, 100))]
    most = 20_000 if random.random() < 0.1 else 50
    return content[:at] + piece * int(random.integers(1, most)) + content[at:]


def _splice(content: bytes, random: Random, others: Sequence[bytes]) -> bytes:
    other = others[int(random.integers(len(others)))]
    return content[: _place(content, random)] + other[_place(other, random) :]


def _word(content: bytes, random: Random, others: Sequence[bytes]) -> bytes:
    at, word = _place(content, random), _WORDS[int(random.integers(len(_WORDS)))]
    times = 1 if random.random() < 0.7 else int(random.choice([10, 1000, 50_000]))
    return content[:at] + word * times + content[at:]


def _number(content: bytes, random: Random, others: Sequence[bytes]) -> bytes:
    found = list(_NUMBER.finditer(content[:200_000]))
    if not found:
        return _word(content, random, others)
    match = found[int(random.integers(len(found)))]
    new = _NUMBERS[int(random.integers(len(_NUMBERS)))].encode()
    return content[: match.start()] + new + content[match.end() :]


def _line(content: bytes, random: Random, others: Sequence[bytes]) -> bytes:
    lines = content.split(b"\n")
    one, two = int(random.integers(len(lines))), int(random.integers(len(lines)))
    kind = random.random()
    if kind < 0.3:
        del lines[one]
    elif kind < 0.6:
        lines[one], lines[two] = lines[two], lines[one]
    else:
        times = min(int(random.choice([1, 2, 500])), 1 + 2_000_000 // (len(lines[two]) + 1))
        lines[one:one] = [lines[two]] * times
    return b"\n".join(lines)


def _encoding(content: bytes, random: Random, others: Sequence[bytes]) -> bytes:
    text = content.decode("utf-8", errors="replace")
    return text.encode(str(random.choice(["utf-16", "utf-16-le", "cp1252", "utf-32"])), errors="replace")


_ON_BYTES: tuple[Change, ...] = (_flip, _noise, _integer, _integer, _cut, _remove, _repeat, _splice)
_ON_TEXT: tuple[Change, ...] = (_word, _number, _number, _line, _encoding, _repeat)


def _json(content: bytes, random: Random) -> bytes:
    try:
        document = json.loads(content)
    except (ValueError, RecursionError):
        return _number(content, random, [content])
    holder, key = _somewhere(document, random)
    if holder is None:
        return content
    kind = random.random()
    if kind < 0.15:
        del holder[key]
    elif kind < 0.3:
        holder[key] = [holder[key]]
    elif kind < 0.35:
        nested: object = 0
        for _ in range(int(random.choice([50, 900]))):
            nested = [nested]
        holder[key] = nested
    else:
        holder[key] = _STRANGE[int(random.integers(len(_STRANGE)))]
    return json.dumps(document).encode()


def _somewhere(document: object, random: Random) -> tuple[dict | list | None, object]:
    """A container in a document and one of its keys."""
    holder, key, now = None, None, document
    while isinstance(now, (dict, list)) and now and (holder is None or random.random() < 0.8):
        keys = list(now) if isinstance(now, dict) else range(len(now))
        holder, key = now, keys[int(random.integers(len(keys)))]
        now = now[key]
    return holder, key


def _glb(content: bytes, random: Random) -> bytes:
    try:
        (size,) = struct.unpack_from("<I", content, 12)
        text, rest = content[20 : 20 + size], content[20 + size :]
    except struct.error:
        return content + b"\0"
    if random.random() < 0.3:
        rest = _one(rest, random, [rest]) if rest else rest
    else:
        text = _json(text.rstrip(b" \0"), random)
    text += b" " * (-len(text) % 4)
    return (
        struct.pack("<4sII", b"glTF", 2, 20 + len(text) + len(rest))
        + struct.pack("<I4s", len(text), b"JSON")
        + text
        + rest
    )


def _archive(content: bytes, random: Random, others: Sequence[bytes]) -> bytes:
    try:
        with zipfile.ZipFile(io.BytesIO(content)) as archive:
            members = [(info, archive.read(info)) for info in archive.infolist()]
    except Exception:  # damaged already
        return _noise(content, random, others)
    number = int(random.integers(len(members))) if members else 0
    stream = io.BytesIO()
    with warnings.catch_warnings(), zipfile.ZipFile(stream, "w") as archive:
        warnings.simplefilter("ignore")
        for place, (info, data) in enumerate(members):
            if place == number and random.random() < 0.1:
                continue
            data = _one(data, random, [data]) if place == number else data
            archive.writestr(info.filename, data, zipfile.ZIP_DEFLATED if random.random() < 0.5 else info.compress_type)
    return stream.getvalue()


def _array_header(content: bytes, random: Random) -> bytes:
    """Another shape, type or order in the header of an array."""
    (length,) = struct.unpack_from("<H", content, 8)
    head = content[10 : 10 + length]
    kind = random.random()
    if kind < 0.6:
        head = _number(head, random, [head])
    elif kind < 0.8:
        new = random.choice(
            [b"'<f8'", b"'|O'", b"'<U9'", b"'|S0'", b"'<M8[s]'", b"'|V8'", b"'<c16'", b"'<f2'", b"'>i4'"]
        )
        head = re.sub(rb"'[<>|=][a-zA-Z]\d*'", bytes(new), head, count=1)
    else:
        head = _one_of_text(head, random)
    return content[:8] + struct.pack("<H", len(head) & 0xFFFF) + head + content[10 + length :]


def _one_of_text(content: bytes, random: Random) -> bytes:
    return _ON_TEXT[int(random.integers(len(_ON_TEXT)))](content, random, [content])
