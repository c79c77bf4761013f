"""``--face MY.glb``: a face in somebody else's GLB, checked before the work is done."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

from mien.errors import InputError

__all__ = ["checked_glb"]


def checked_glb(face: str, outputs: Sequence[Path], deformer: str) -> Path:
    """Refuse what cannot be done with a foreign GLB before any work is done."""
    from mien.output.driven_glb import driven_meshes, read_chunks

    if deformer != "blendshapes":
        raise InputError(f"--deformer {deformer} is for mien's own faces; {face} moves by its morph targets")
    for path in outputs:
        if path.suffix.lower() in (".mp4", ".png"):
            raise InputError(f"{face} is driven and written as .glb; only mien's own faces are drawn: not {path}")
    document, _ = read_chunks(face)
    if not any(recipe for mesh in driven_meshes(face, document) for recipe in mesh.recipes):
        raise InputError(f"{face} has no morph target with a known name (ARKit, VRM or viseme): nothing could move")
    return Path(face)
