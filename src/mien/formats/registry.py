"""Which formats there are; the suffix of a file name picks one.

Formats of other packages join by entry points of the group ``mien.formats`` (``docs/extending.md``).
"""

from __future__ import annotations

import re
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING

from mien.animation.animation import Animation
from mien.core.errors import InputError, Note, unknown_name
from mien.core.files import check_writable
from mien.core.plug_ins import plug_ins
from mien.face.model import Face

if TYPE_CHECKING:
    from mien.face.render.view import View

__all__ = [
    "EXPORTERS",
    "FRAMES",
    "PLUG_INS",
    "Exporter",
    "GlbStyle",
    "Progress",
    "check_output",
    "draws_pictures",
    "exporters",
    "save",
    "shows_face",
]

PLUG_INS = "mien.formats"
"""The group of entry points by which other packages bring formats; each entry point names an `Exporter`."""

FRAMES = "%05d.png"
"""The end of a name that stands for one picture a frame; any ``%0Nd`` does."""
_NUMBERED = re.compile(r"%0?\d*d.*\.png$", re.IGNORECASE)


@dataclass(frozen=True)
class GlbStyle:
    """How a ``.glb`` is written.

    Attributes
    ----------
    compact : bool
        mien's own face in whole numbers with ARKit's 52 targets alone (`mien.formats.compact_glb`).
    meshopt : bool
        Compact, and compressed besides, for players that know ``EXT_meshopt_compression``.
    clip : str
        Name of the animation; "" for ``performance`` on mien's own face, ``mien`` on others.
    """

    compact: bool = False
    meshopt: bool = False
    clip: str = ""


Progress = Callable[[int, int], None]
"""Called with (frames done, frames in all)."""


@dataclass(frozen=True)
class Exporter:
    """One output format.

    Attributes
    ----------
    suffix : str
        With its dot, as it is commonly spelt; any case is accepted.
    title : str
        What the file is, for help texts.
    loses : str
        What of an `Animation` the file does not hold, in one line.
    shows_face : bool
        Whether it needs a `Face`.
    write : callable
        Given the animation, the path, the face (None unless ``shows_face``) and the progress callback; where ``draws``
        also the `View`.
    check : callable
        Raises MissingPartError where a library that the format needs is not installed.
    companion : callable or None
        Given the path, the folder beside it in which the format keeps pictures and sound.
    draws : callable or None
        Of a format that draws the face: given the path and the `View`, raises InputError where the format cannot hold
        it.
    """

    suffix: str
    title: str
    loses: str
    shows_face: bool
    write: Callable[..., tuple[Note, ...]]
    check: Callable[[], None] = lambda: None
    companion: Callable[[Path], Path] | None = None
    draws: Callable[[Path, View], None] | None = None


def _needed(face: Face | None) -> Face:
    if face is not None:
        return face
    from mien.face.library import load_face

    return load_face("default")


def _write_video(
    animation: Animation, path: Path, face: Face | None, progress: Progress | None, view: View | None
) -> tuple[Note, ...]:
    from mien.formats.video import write_video

    return write_video(animation, _needed(face), path, view=view, progress=progress)


def _write_gif(
    animation: Animation, path: Path, face: Face | None, progress: Progress | None, view: View | None
) -> tuple[Note, ...]:
    from mien.formats.picture_files import write_gif

    return write_gif(animation, _needed(face), path, view=view, progress=progress)


def _write_frames(
    animation: Animation, path: Path, face: Face | None, progress: Progress | None, view: View | None
) -> tuple[Note, ...]:
    from mien.formats.picture_files import write_png_frames

    return write_png_frames(animation, _needed(face), path, view=view, progress=progress)


def _write_contact_sheet(
    animation: Animation, path: Path, face: Face | None, _: Progress | None, view: View | None
) -> tuple[Note, ...]:
    from mien.formats.contact_sheet import write_contact_sheet

    return write_contact_sheet(animation, _needed(face), path, view=view)


def _video_view(path: Path, view: View) -> None:
    from mien.formats.video import check_film

    check_film(path, view)


def _frames_view(path: Path, _: View) -> None:
    from mien.formats.picture_files import frame_files

    frame_files(path, 0)


def _sheet_view(path: Path, view: View) -> None:
    if view.transparent:
        raise InputError(f"{path}: a contact sheet lies on paper; for transparent pictures give NAME%05d.png")


def _write_glb(animation: Animation, path: Path, face: Face | None, _: Progress | None) -> tuple[Note, ...]:
    from mien.formats.gltf import write_glb

    return write_glb(animation, _needed(face), path)


def _styled_glb(animation: Animation, path: Path, face: Face | None, style: GlbStyle) -> tuple[Note, ...]:
    from mien.formats.gltf import write_glb

    clip = style.clip or "performance"
    return write_glb(animation, _needed(face), path, compact=style.compact, meshopt=style.meshopt, clip=clip)


def _write_fbx(animation: Animation, path: Path, face: Face | None, _: Progress | None) -> tuple[Note, ...]:
    from mien.core.temporary_folder import temporary_folder
    from mien.formats.fbx import fbx_of

    with temporary_folder() as folder:
        notes = _write_glb(animation, folder / "face.glb", face, None)
        fbx_of(folder / "face.glb", path, animation.rate)
    return notes


def _check_fbx() -> None:
    from mien.formats.fbx import check_fbx

    check_fbx()


def _write_livelink(animation: Animation, path: Path, _: Face | None, __: Progress | None) -> tuple[Note, ...]:
    from mien.formats.livelink import write_livelink

    return write_livelink(animation, path)


def _write_fap(animation: Animation, path: Path, face: Face | None, _: Progress | None) -> tuple[Note, ...]:
    from mien.formats.fap import write_fap

    return write_fap(animation, _needed(face), path)


def _write_textgrid(animation: Animation, path: Path, _: Face | None, __: Progress | None) -> tuple[Note, ...]:
    from mien.formats.textgrid import write_textgrid

    speech = animation.utterance
    return write_textgrid((speech.words, speech.spelled_phones), speech.duration, path)


def _write_sound(animation: Animation, path: Path, _: Face | None, __: Progress | None) -> tuple[Note, ...]:
    from mien.formats.wav import write_sound

    return write_sound(animation.utterance.audio, path)


def _write_usd(animation: Animation, path: Path, face: Face | None, _: Progress | None) -> tuple[Note, ...]:
    from mien.formats.usd import write_usd

    return write_usd(animation, _needed(face), path)


def _check_usd() -> None:
    from mien.formats.usd import check_usd

    check_usd()


def _usd_companion(path: Path) -> Path:
    from mien.formats.usd import companion_folder

    return companion_folder(path)


def _write_c3d(animation: Animation, path: Path, face: Face | None, _: Progress | None) -> tuple[Note, ...]:
    from mien.formats.c3d import write_c3d

    return write_c3d(animation, _needed(face), path)


def _write_native(animation: Animation, path: Path, _: Face | None, __: Progress | None) -> tuple[Note, ...]:
    from mien.formats.native import write_native

    return write_native(animation, path)


EXPORTERS: tuple[Exporter, ...] = (
    Exporter(
        ".mp4",
        "video with sound (H.264, AAC)",
        "everything but one view and the sound, both compressed; transparency",
        True,
        _write_video,
        draws=_video_view,
    ),
    Exporter(
        ".webm",
        "video with sound, also transparent (VP9, Opus)",
        "everything but one view and the sound, both compressed",
        True,
        _write_video,
        draws=_video_view,
    ),
    Exporter(
        ".mov",
        "video with sound for editing, also transparent (ProRes, PCM)",
        "everything but one view and the sound",
        True,
        _write_video,
        draws=_video_view,
    ),
    Exporter(
        ".gif",
        "moving picture, also transparent",
        "everything but one view in 256 colours, and the sound",
        True,
        _write_gif,
        draws=lambda path, view: None,
    ),
    Exporter(
        FRAMES,
        "one picture for each frame, also transparent",
        "everything but one view, and the sound",
        True,
        _write_frames,
        draws=_frames_view,
    ),
    Exporter(
        ".png",
        "contact sheet of key frames",
        "all motion between the key frames, and the sound",
        True,
        _write_contact_sheet,
        draws=_sheet_view,
    ),
    Exporter(
        ".glb",
        "animated 3D face (glTF 2.0, morph targets by name: ARKit's 52 and those beyond)",
        "the sound itself, markers, phones, score; skin scatter; textures are JPEG, numbers 32-bit",
        True,
        _write_glb,
    ),
    Exporter(
        ".fbx",
        "animated 3D face, by way of Blender (FBX, morph targets by name)",
        "the sound, markers, words, phones, score; what a GLB loses; textures are embedded",
        True,
        _write_fbx,
        _check_fbx,
    ),
    Exporter(
        ".usdz",
        "animated 3D face with its sound in one file (USD: UsdSkel blend shapes)",
        "markers, phones, score; skin scatter; textures are JPEG, numbers 32-bit, the sound 16-bit",
        True,
        _write_usd,
        _check_usd,
    ),
    Exporter(
        ".usdc",
        "animated 3D face (USD, binary layer; pictures and sound in a folder beside it)",
        "markers, phones, score; skin scatter; textures are JPEG, numbers 32-bit, the sound 16-bit",
        True,
        _write_usd,
        _check_usd,
        _usd_companion,
    ),
    Exporter(
        ".usda",
        "animated 3D face (USD, text layer; pictures and sound in a folder beside it)",
        "markers, phones, score; skin scatter; textures are JPEG, numbers 32-bit, the sound 16-bit",
        True,
        _write_usd,
        _check_usd,
        _usd_companion,
    ),
    Exporter(
        ".c3d",
        "markers on the face's skin with the sound (motion capture)",
        "channels, words, phones, score, all motion between the markers; numbers are 32-bit",
        True,
        _write_c3d,
    ),
    Exporter(
        ".csv",
        "Live Link Face recording (Unreal, Blender, Maya)",
        "the sound, markers, words, phones, score, tongue and muscles beyond ARKit's 52; numbers have eight decimals",
        False,
        _write_livelink,
    ),
    Exporter(
        ".fap",
        "MPEG-4 face animation parameters (text)",
        "the sound, markers, words, phones, score; all but the feature points' motion along the standard's axes",
        True,
        _write_fap,
    ),
    Exporter(
        ".TextGrid", "words and phones in time (Praat)", "all motion, the sound, the score", False, _write_textgrid
    ),
    Exporter(".wav", "the sound (24 bit, one channel)", "everything but the sound", False, _write_sound),
    Exporter(".json", "the native animation", "nothing", False, _write_native),
)


def exporters() -> tuple[Exporter, ...]:
    """Every format that can be written: mien's own, then those that installed packages bring.

    Raises
    ------
    InputError
        If a package brings something that is no `Exporter`, or takes the suffix of another format.

    Examples
    --------
    >>> [exporter.suffix for exporter in exporters()][:3]
    ['.mp4', '.webm', '.mov']
    """
    return EXPORTERS + _plugged_in()


def _plugged_in() -> tuple[Exporter, ...]:
    taken = {exporter.suffix.lower(): "mien" for exporter in EXPORTERS}
    found = []
    for package, exporter in plug_ins(PLUG_INS, lambda thing: isinstance(thing, Exporter), "an Exporter").values():
        if exporter.suffix.lower() in taken:
            other = taken[exporter.suffix.lower()]
            raise InputError(f"the package {package} brings the format {exporter.suffix}, which {other} has already")
        taken[exporter.suffix.lower()] = package
        found.append(exporter)
    return tuple(found)


def _exporter(path: Path) -> Exporter:
    if _NUMBERED.search(path.name):
        return next(exporter for exporter in EXPORTERS if exporter.suffix == FRAMES)
    for exporter in EXPORTERS:  # other packages are looked up only where none of mien's own formats is meant
        if exporter.suffix.lower() == path.suffix.lower():
            return exporter
    known = {exporter.suffix.lower(): exporter for exporter in exporters()}
    if path.suffix.lower() in known:
        return known[path.suffix.lower()]
    names = [exporter.suffix for exporter in exporters()]
    if not path.suffix:
        raise InputError(f"cannot tell the format of {path}: end its name in one of {', '.join(names)}")
    raise unknown_name("output format", path.suffix, names)


def check_output(path: str | Path, view: View | None = None) -> Path:
    """Say early, before long work, whether `save` could write ``path`` so; returns it as a Path.

    Raises
    ------
    InputError
        If the suffix is not that of a format, or the format cannot hold the view.
    OutputError
        If the folder is missing or not writable.
    MissingPartError
        If a library that the format needs is not installed.

    Examples
    --------
    >>> check_output("line.mp5")  # doctest: +ELLIPSIS
    Traceback (most recent call last):
        ...
    mien.core.errors.InputError: unknown output format '.mp5': did you mean '.mp4'? known: ...
    """
    path = Path(path)
    exporter = _exporter(path)
    exporter.check()
    if exporter.draws is not None and view is not None:
        exporter.draws(path, view)
    return check_writable(path)


def shows_face(path: str | Path) -> bool:
    """Whether what is written to ``path`` needs a face.

    Examples
    --------
    >>> shows_face("line.mp4"), shows_face("line.csv")
    (True, False)
    """
    return _exporter(Path(path)).shows_face


def draws_pictures(path: str | Path) -> bool:
    """Whether what is written to ``path`` shows the face in pictures, from a `View`.

    Examples
    --------
    >>> draws_pictures("line%05d.png"), draws_pictures("line.glb")
    (True, False)
    """
    return _exporter(Path(path)).draws is not None


def save(
    animation: Animation,
    path: str | Path,
    *,
    face: Face | None = None,
    progress: Progress | None = None,
    glb: GlbStyle | None = None,
    view: View | None = None,
) -> tuple[Note, ...]:
    """Write an animation to a file; the suffix picks the format (`exporters`).

    Parameters
    ----------
    animation : Animation
    path : path-like
        Replaced if it exists; never left half-written.
    face : Face, optional
        For the formats that show one; the default face otherwise.
    view : View, optional
        For the formats that draw pictures; the portrait at 1280 x 720 otherwise (on contact sheets, heads).
    progress : callable, optional
        Called with (frames done, frames in all) while a video is made.
    glb : GlbStyle, optional
        How a ``.glb`` is written.

    Returns
    -------
    tuple of Note
        What the writer had to change or leave out beyond what the format always loses.

    Raises
    ------
    InputError
        If the suffix is not that of a format.
    OutputError
        If the file cannot be written.
    """
    path, exporter = check_output(path, view), _exporter(Path(path))
    if glb is not None and path.suffix.lower() == ".glb":
        return _styled_glb(animation, path, face, glb)
    if exporter.draws is None:
        return exporter.write(animation, path, face, progress)
    return exporter.write(animation, path, face, progress, view)
