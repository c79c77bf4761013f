"""Which writer serves where the face is somebody else's."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

from mien.animation.animation import Animation
from mien.core.errors import Note
from mien.core.temporary_folder import temporary_folder
from mien.face.foreign.drawn import drawn_face
from mien.face.foreign.recognition import ForeignFace
from mien.face.render.view import View
from mien.formats.driven_glb import NAME, drive_glb
from mien.formats.fbx import fbx_of
from mien.formats.registry import GlbStyle, Progress, draws_pictures, save

__all__ = ["save_on_foreign"]


def save_on_foreign(
    animation: Animation,
    target: Path,
    face: ForeignFace,
    progress: Progress | None,
    glb: GlbStyle | None = None,
    view: View | None = None,
) -> tuple[Note, ...]:
    """Write one file, as `mien.formats.registry.save`, with a face of another maker."""
    if target.suffix.lower() == ".glb":
        clip = glb.clip if glb is not None and glb.clip else NAME
        notes = drive_glb(animation.channels, face, target, clip=clip)
        if glb is not None and (glb.compact or glb.meshopt):
            told = f"{target.name}: --compact is for mien's own face; yours is written as it is"
            return (*notes, Note("warning", told))
        return notes
    if target.suffix.lower() == ".fbx":
        with temporary_folder() as folder:
            notes = drive_glb(animation.channels, face, folder / "face.glb")
            fbx_of(folder / "face.glb", target, animation.rate)
        return notes
    if draws_pictures(target):
        drawn = drawn_face(face)
        shown = replace(animation, channels=drawn.track(animation.channels))
        notes = save(shown, target, face=drawn.face, view=view, progress=progress)
        return (*(Note("warning", fault) for fault in drawn.notes), *notes)
    if target.suffix.lower() in (".usda", ".usdc", ".usdz", ".c3d"):
        drawn = drawn_face(face)
        told = "sums of channels are held in 0..1 by mien only: the file has one target for each channel"
        return (Note("note", told), *save(animation, target, face=drawn.by_channels(), progress=progress))
    if target.suffix.lower() == ".fap":
        told = f"{target}: face animation parameters are measured on the default face, not on {face.document.path.name}"
        return (Note("note", told), *save(animation, target))
    return save(animation, target)
