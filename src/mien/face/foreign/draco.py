"""Meshes that a file keeps in Draco's compression, through Google's decoder (the package DracoPy, an extra).

Source: KHR_draco_mesh_compression. Morph targets and skins stand beside the compressed data, in its decoded order.
"""

from __future__ import annotations

from collections.abc import Iterator
from importlib.util import find_spec
from typing import Any

import numpy as np
from numpy.typing import NDArray

from mien.core.errors import InputError
from mien.core.limits import check_size
from mien.face.foreign.gltf_document import GltfDocument

__all__ = ["DRACO", "decoded_draco", "draco_missing", "uses_draco"]

DRACO = "KHR_draco_mesh_compression"
_MOST_FROM_BYTE = 2000  # vertices that one compressed byte can stand for, in earnest


def uses_draco(document: GltfDocument) -> bool:
    """Whether any mesh is compressed with it."""
    return any(True for _ in _compressed(document))


def draco_missing() -> str:
    """What to install for it; "" if the decoder is there."""
    return (
        "" if find_spec("DracoPy") else "the decoder is an extra: pip install 'mien[files]' (or: pip install DracoPy)"
    )


def _compressed(document: GltfDocument) -> Iterator[tuple[dict[str, Any], dict[str, Any]]]:
    for mesh in document.list_of("meshes"):
        for primitive in mesh["primitives"]:
            packed = (primitive.get("extensions") or {}).get(DRACO)
            if isinstance(packed, dict):
                yield primitive, packed


def decoded_draco(document: GltfDocument) -> dict[int, NDArray[Any]]:
    """Decoded values by accessor, shape (count, width): attributes and corners of all compressed primitives.

    Raises
    ------
    InputError
        If the decoder is not installed, or the data cannot be decoded.
    """
    missing = draco_missing()
    if missing:
        raise InputError(f"{document.path}: its meshes are compressed with Draco; {missing}")
    import DracoPy

    found: dict[int, NDArray[Any]] = {}
    accessors = document.list_of("accessors")
    for primitive, packed in _compressed(document):
        data = document.view(packed.get("bufferView", -1))
        for number in (*primitive.get("attributes", {}).values(), primitive.get("indices", -1)):
            count = accessors[number].get("count", 0) if isinstance(number, int) and 0 <= number < len(accessors) else 0
            check_size("numbers", count * 4, f"{document.path}, accessor {number}")
            if count > _MOST_FROM_BYTE * len(data):
                raise InputError(f"{document.path}: accessor {number} claims {count} elements in {len(data)} bytes")
        try:
            mesh = DracoPy.decode(data)
            for name, identity in packed["attributes"].items():
                values = mesh.get_attribute_by_unique_id(identity)["data"]
                found[primitive["attributes"][name]] = np.asarray(values).reshape(len(mesh.points), -1)
            if "indices" in primitive:
                found[primitive["indices"]] = np.asarray(mesh.faces, dtype=np.uint32).reshape(-1, 1)
        except (KeyError, TypeError, ValueError, AttributeError, RuntimeError) as problem:
            raise InputError(f"{document.path}: a mesh cannot be decoded as Draco ({problem!r})") from problem
        except DracoPy.FileTypeException as problem:
            raise InputError(f"{document.path}: a mesh cannot be decoded as Draco ({problem})") from problem
    return found
