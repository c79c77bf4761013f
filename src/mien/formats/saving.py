"""Writing an animation to files: the suffix of each path picks its format (``docs/formats.md``)."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import TYPE_CHECKING

from mien.animation.animation import Animation
from mien.core.errors import InputError, Note
from mien.face.model import Face

if TYPE_CHECKING:
    from mien.face.foreign.recognition import ForeignFace
    from mien.face.render.view import View
    from mien.formats.registry import GlbStyle

__all__ = ["save"]

Progress = Callable[[int, int], None]


def save(
    animation: Animation,
    *paths: str | Path,
    face: str | Path | Face | ForeignFace | None = "default",
    names: str | Path | None = None,
    view: View | None = None,
    progress: Progress | None = None,
    glb: GlbStyle | None = None,
) -> tuple[Note, ...]:
    """Write an animation; the suffix of each path picks its format (``docs/formats.md``).

    Parameters
    ----------
    animation : Animation
    *paths : str or Path
        As `mien.formats.registry.exporters` names them; all are checked before the first is written.
    face : str, Path, Face or ForeignFace
        The face for the formats that show one: by name, loaded, or one of another maker (``.glb``, ``.vrm``,
        ``.gltf``), which is driven by its own morph targets and written with everything else in it. None: the default.
    names : str, Path or None
        A table of names of your own for such a face (``docs/faces.md``).
    view : View or None
        Size, camera, light, background, crop and quality of pictures (`mien.face.render.view.View`).
    progress : callable (done, total) or None
        Called while frames are drawn.
    glb : GlbStyle or None
        How a ``.glb`` is written: compact, compressed, the name of its animation.

    Returns
    -------
    tuple of Note
        What a format could not hold beyond what it always loses.

    Raises
    ------
    InputError
        If a suffix or the face is not known, no path is given, or what is to be written is no animation.
    OutputError
        If a file cannot be written; nothing is left half-written.
    """
    from mien.face.library import is_named_face, load_face
    from mien.formats.registry import check_output, shows_face
    from mien.formats.registry import save as save_one

    if not isinstance(animation, Animation):
        raise InputError(f"expected an Animation to write, got {type(animation).__name__}")
    if not paths:
        raise InputError('expected a path to write to, such as "line.mp4", got none')
    targets = [check_output(path, view) for path in paths]
    if face is not None and not isinstance(face, Face) and not is_named_face(face):
        from mien.face.foreign.gltf_document import is_gltf
        from mien.face.foreign.known_face import known_face, note_on_mouth
        from mien.face.foreign.recognition import ForeignFace

        if isinstance(face, (str, Path)) and is_gltf(face):
            face = known_face(face, names)
        if isinstance(face, ForeignFace):
            from mien.formats.foreign_faces import save_on_foreign

            saved = [save_on_foreign(animation, target, face, progress, glb, view) for target in targets]
            written = tuple(note for notes in saved for note in notes)
            return (*note_on_mouth(face), *written) if any(map(shows_face, targets)) else written
    if names is not None:
        raise InputError("names are for a face in .glb, .vrm or .gltf")
    if is_named_face(face) and not any(shows_face(target) for target in targets):
        face = None  # reading it takes longer than writing the file
    shown = load_face(face) if isinstance(face, (str, Path)) else face
    each = [save_one(animation, target, face=shown, progress=progress, glb=glb, view=view) for target in targets]
    return tuple(note for notes in each for note in notes)
