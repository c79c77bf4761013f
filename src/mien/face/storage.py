"""Keeping a `Face` in one compact file, and reading it back.

A face file is a NumPy ``.npz`` archive. Its member ``face`` is a JSON text with everything that is not an array;
the arrays of part ``p`` are named ``p/...``. Positions and target offsets are whole hundredths of a millimetre in
16 bits, texture coordinates 16-bit fractions, pictures the bytes of a PNG or JPEG file.
"""

from __future__ import annotations

import io
import json
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray
from PIL import Image

from mien.core.border import guarded
from mien.core.errors import InputError
from mien.core.files import replace_when_complete
from mien.core.limits import load_arrays
from mien.core.pictures import opened_picture
from mien.core.plain_text import parsed_json
from mien.face.model import Eye, Face, Material, Part, Target

__all__ = ["read_face", "write_face"]

FORMAT = "mien-face-1"
_STEP = 0.01  # mm
_LARGEST = 327.0  # mm, what 16 bits hold at that step
_SIDES = ("Left", "Right")
_UV_STEP = 1 / 65535

Arrays = dict[str, NDArray[Any]]


def write_face(face: Face, path: str | Path, jpeg_quality: int = 88) -> None:
    """Write a face; the same face gives the same bytes.

    Parameters
    ----------
    face : Face
    path : str or Path
        Ends in ``.npz`` by custom.
    jpeg_quality : int
        Of the textures, 1..95.

    Raises
    ------
    InputError
        If a position lies more than 327 mm from the origin, which the format cannot hold.
    OutputError
        If the file cannot be written.
    """
    arrays: Arrays = {}
    parts = []
    for part in face.parts:
        parts.append({"name": part.name, "material": _material_facts(part.material), "targets": list(part.targets)})
        _pack_part(part, arrays, jpeg_quality)
    facts = {
        "format": FORMAT,
        "name": face.name,
        "licence": face.licence,
        "head_pivot": face.head_pivot,
        "eyes": [vars(eye) for eye in face.eyes],
        "sites": {name: [part, int(vertex)] for name, (part, vertex) in face.sites.items()},
        "parts": parts,
    }
    arrays["face"] = np.frombuffer(json.dumps(facts).encode(), np.uint8)
    with replace_when_complete(path) as unfinished, unfinished.open("wb") as file:
        np.savez_compressed(file, allow_pickle=False, **arrays)


def _material_facts(material: Material) -> dict[str, Any]:
    facts = dict(vars(material))
    del facts["texture"]
    return facts


def _hundredths(part: str, millimetres: NDArray[np.float32]) -> NDArray[np.int16]:
    if np.abs(millimetres).max(initial=0.0) > _LARGEST:
        raise InputError(f"part {part!r} reaches farther than {_LARGEST:g} mm: is it in millimetres about the eyes?")
    steps: NDArray[np.int16] = np.rint(millimetres / _STEP).astype(np.int16)
    return steps


def _pack_part(part: Part, arrays: Arrays, jpeg_quality: int) -> None:
    def keep(name: str, array: NDArray[Any]) -> None:
        arrays[f"{part.name}/{name}"] = array

    keep("vertices", _hundredths(part.name, part.vertices))
    index_type = np.uint16 if len(part.vertices) <= 65535 else np.int32
    keep("triangles", part.triangles.astype(index_type))
    keep("uv", np.rint(np.clip(part.uv, 0, 1) / _UV_STEP).astype(np.uint16))
    keep("colours", np.rint(np.clip(part.colours, 0, 1) * 255).astype(np.uint8))
    keep("head_weight", np.rint(np.clip(part.head_weight, 0, 1) * 255).astype(np.uint8))
    if part.material.texture is not None:
        picture = io.BytesIO()
        image = Image.fromarray(part.material.texture)
        if image.mode == "RGBA":
            image.save(picture, "PNG")
        else:
            image.save(picture, "JPEG", quality=jpeg_quality, subsampling=0)
        keep("texture", np.frombuffer(picture.getvalue(), np.uint8))
    for name, target in part.targets.items():
        keep(f"targets/{name}/vertices", target.vertices.astype(index_type))
        keep(f"targets/{name}/offsets", _hundredths(part.name, target.offsets))


@guarded("a face of mien")
def read_face(path: str | Path) -> Face:
    """Read a face file and check that its indices and numbers fit together.

    Raises
    ------
    InputError
        If the file is missing, is no face file, or is damaged.
    """
    path = Path(path)
    if not path.exists():
        raise InputError(f"there is no face file {path}")
    arrays = load_arrays(path)
    facts = parsed_json(arrays["face"].tobytes())
    if facts["format"] != FORMAT:
        raise InputError(f"{path} is a face in format {str(facts['format'])[:80]!r}; this mien reads {FORMAT!r}")
    face = Face(
        name=str(facts["name"]),
        parts=tuple(_unpack_part(part, arrays, path) for part in facts["parts"]),
        eyes=tuple(Eye(**{**eye, "centre": tuple(eye["centre"])}) for eye in facts["eyes"]),
        head_pivot=tuple(facts["head_pivot"]),
        sites={name: (part, vertex) for name, (part, vertex) in facts["sites"].items()},
        licence=facts["licence"],
    )
    faults = _faults(face)
    if faults:
        raise InputError(f"{path}: " + "; ".join(faults))
    return face


def _unpack_part(facts: Mapping[str, Any], arrays: Arrays, path: Path) -> Part:
    name = facts["name"]

    def millimetres(key: str) -> NDArray[np.float32]:
        return arrays[f"{name}/{key}"].astype(np.float32) * np.float32(_STEP)

    picture = arrays.get(f"{name}/texture")
    texture = None
    if picture is not None:
        with opened_picture(picture.tobytes(), f"{path}, {name}/texture") as opened:
            texture = np.asarray(opened.convert("RGBA" if opened.mode == "RGBA" else "RGB"))
    material = dict(facts["material"], colour=tuple(facts["material"]["colour"]), texture=texture)
    return Part(
        name=name,
        vertices=millimetres("vertices"),
        triangles=arrays[f"{name}/triangles"].astype(np.int32),
        uv=arrays[f"{name}/uv"].astype(np.float32) * np.float32(_UV_STEP),
        colours=arrays[f"{name}/colours"].astype(np.float32) / np.float32(255),
        material=Material(**material),
        head_weight=arrays[f"{name}/head_weight"].astype(np.float32) / np.float32(255),
        targets={
            target: Target(
                arrays[f"{name}/targets/{target}/vertices"].astype(np.int32), millimetres(f"targets/{target}/offsets")
            )
            for target in facts["targets"]
        },
    )


def _faults(face: Face) -> list[str]:
    names = [part.name for part in face.parts]
    faults = [f"part {name!r} is there twice" for name in sorted({n for n in names if names.count(n) > 1})]
    if not names:
        faults.append("it has no parts")
    sizes = {part.name: len(part.vertices) for part in face.parts}
    for part in face.parts:
        n = sizes[part.name]
        rows = {"uv": part.uv, "colours": part.colours, "head_weight": part.head_weight}
        faults += [
            f"part {part.name!r}: {len(a)} rows of {key} for {n} vertices" for key, a in rows.items() if len(a) != n
        ]
        if part.triangles.size and not 0 <= part.triangles.min() <= part.triangles.max() < n:
            faults.append(f"part {part.name!r}: a triangle names a vertex beyond the {n} there are")
        for name, target in part.targets.items():
            reach = target.vertices.min(initial=0) < 0 or target.vertices.max(initial=-1) >= n
            if len(target.vertices) != len(target.offsets) or reach:
                faults.append(f"part {part.name!r}: target {name!r} does not fit its vertices")
    faults += [f"eye {eye.part!r} is no part" for eye in face.eyes if eye.part not in sizes]
    faults += [
        f"eye {eye.part!r}: its side is {eye.side!r}, not Left or Right" for eye in face.eyes if eye.side not in _SIDES
    ]
    numbers = [*face.head_pivot, *(value for eye in face.eyes for value in eye.centre)]
    if len(face.head_pivot) != 3 or any(len(eye.centre) != 3 for eye in face.eyes) or not np.isfinite(numbers).all():
        faults.append("the head's pivot and the eyes' centres are three finite numbers each")
    faults += [f"site {s!r} is on no vertex" for s, (part, v) in face.sites.items() if not 0 <= v < sizes.get(part, 0)]
    return faults
