"""``--face MY.glb``: a face in somebody else's GLB, checked before the work and driven after it."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

from mien.animation import Animation
from mien.errors import InputError, Note

__all__ = ["checked_glb", "drive"]


def checked_glb(face: str, outputs: Sequence[Path], deformer: str) -> Path:
    """Refuse what cannot be done with a foreign GLB before any work is done."""
    from mien.output.driven_glb import read_chunks, recipe_of_target, target_names

    if deformer != "blendshapes":
        raise InputError(f"--deformer {deformer} is for mien's own faces; {face} moves by its morph targets")
    for path in outputs:
        if path.suffix.lower() != ".glb":
            raise InputError(f"a face in a GLB is written as .glb only, not {path}")
        if path.resolve() == Path(face).resolve():
            raise InputError(f"{path} is both read and written: give the output another name")
    document, _ = read_chunks(face)
    if not any(recipe_of_target(name) for mesh in document.get("meshes", []) for name in target_names(mesh)):
        raise InputError(f"{face} has no morph target with a known name (ARKit or viseme): nothing could move")
    return Path(face)


def drive(animation: Animation, face: Path, outputs: Sequence[str]) -> tuple[Note, ...]:
    """Write the animation onto the GLB, once for every output."""
    from mien.output.driven_glb import drive_glb

    for path in outputs:
        drive_glb(animation.channels, face, path)
    return (Note("note", "head and eye rotations are not written to a GLB of another maker: its nodes keep their own"),)
