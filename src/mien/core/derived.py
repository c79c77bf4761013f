"""What does not depend on the line is worked out when mien is built: arrays beside the assets that they come from.

``assets/derived/NAME.npz`` holds the arrays and a digest of the files of ``assets`` they were worked out from. Where a
file is not what it was, nothing is read, and the caller works them out anew: slower, never wrong. ``tools/derive.py``
writes them; a test tells when one is out of date.
"""

from __future__ import annotations

import hashlib
import io
from collections.abc import Mapping, Sequence
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from mien.core.assets import asset, assets_folder
from mien.core.files import replace_when_complete

__all__ = ["derived_path", "digest_of", "read_derived", "write_derived"]

Arrays = dict[str, NDArray[Any]]
_DIGEST = "digest"


def derived_path(name: str) -> Path:
    """Where derived arrays of that name are kept."""
    return assets_folder() / "derived" / f"{name}.npz"


def digest_of(sources: Sequence[str]) -> NDArray[np.uint8]:
    """Digest of files of ``assets``, shape (32,).

    Examples
    --------
    >>> len(digest_of(["performance/emotions.toml"]))
    32
    """
    digest = hashlib.blake2b(digest_size=32)
    for source in sources:
        path = asset(source)
        digest.update(f"{source}\n".encode() + _digest_of_file(path, path.stat().st_mtime_ns, path.stat().st_size))
    return np.frombuffer(digest.digest(), np.uint8)


@cache
def _digest_of_file(path: Path, _changed: int, _size: int) -> bytes:
    return hashlib.blake2b(path.read_bytes(), digest_size=32).digest()


def read_derived(name: str, sources: Sequence[str]) -> Arrays | None:
    """Arrays that were worked out from files of ``assets``, by name; None if there are none, or the files changed."""
    try:
        with np.load(io.BytesIO(derived_path(name).read_bytes()), allow_pickle=False) as archive:
            arrays = {key: archive[key] for key in archive.files}
    except FileNotFoundError:
        return None
    return arrays if np.array_equal(arrays.pop(_DIGEST), digest_of(sources)) else None


def write_derived(name: str, sources: Sequence[str], arrays: Mapping[str, NDArray[Any]]) -> Path:
    """Keep arrays beside the digest of the files of ``assets`` that they come from; returns the file."""
    path = derived_path(name)
    path.parent.mkdir(exist_ok=True)
    with replace_when_complete(path) as unfinished, unfinished.open("wb") as file:
        np.savez(file, allow_pickle=False, **arrays, **{_DIGEST: digest_of(sources)})
    return path
