"""``mien face from-photos``: a face shaped and painted after photographs of a person."""

from __future__ import annotations

import argparse
from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from mien.fit.from_photos import PhotoFace
    from mien.fit.photo_marks import Photo

__all__ = ["add_command"]


def add_command(kinds: Any) -> None:
    """Add ``mien face from-photos`` to the face commands."""
    parser = kinds.add_parser("from-photos", help="make a face from photographs: front, side, or more")
    parser.add_argument("photos", metavar="PHOTO", nargs="+", help="the front first, then the side or 45 degrees")
    parser.add_argument("-o", "--output", metavar="FACE.npz", required=True, help="the face to write")
    parser.add_argument("--also", metavar="OUT.glb", help="the face as a GLB with its morph targets, at rest")
    parser.add_argument(
        "--landmarks",
        metavar="POINTS",
        nargs="+",
        help="one file for each photograph, in their order ('-': the tracker), .csv, .json or .toml: names with "
        "pixels from the upper left corner (default: a file named like the photograph beside it, else the tracker)",
    )
    parser.add_argument(
        "--eye-distance", type=float, metavar="MM", help="distance between the eyes (default: that of the average head)"
    )
    parser.add_argument(
        "--hair",
        choices=("keep", "none"),
        default="keep",
        help="use the default hair in the colour of the photograph, or none",
    )
    parser.add_argument(
        "--even-light",
        type=float,
        default=0.9,
        metavar="0..1",
        help="how much of the lighting to remove (default 0.9)",
    )
    parser.add_argument("--texture-size", type=int, default=1536, metavar="N", help="256 to 4096 (default 1536)")
    parser.set_defaults(run=_from_photos)


def _from_photos(options: argparse.Namespace) -> int:
    from pathlib import Path

    from mien.cli.face_fit_command import write_rest
    from mien.face.storage import write_face
    from mien.fit.from_photos import face_from_photos
    from mien.fit.photo_paint import PaintSettings

    path, also = _outputs(options)
    _check_numbers(options)
    photos = _photos(options.photos, options.landmarks)
    paint = PaintSettings(size=options.texture_size, even_light=options.even_light)
    done = face_from_photos(photos, Path(path).stem, options.eye_distance, options.hair == "keep", paint=paint)
    write_face(done.face, path, jpeg_quality=92)
    print(_report(done, photos))
    print(f"{path}: parts: {', '.join(part.name for part in done.face.parts)}")
    if also is not None:
        write_rest(done.face, also)
        print(f"{also}: the face at rest, with its morph targets")
    return 0


def _outputs(options: argparse.Namespace) -> tuple[Any, Any]:
    from mien.core.errors import InputError
    from mien.core.files import check_writable

    path = check_writable(options.output)
    if path.suffix.lower() != ".npz":
        raise InputError(f"-o {path}: a face file ends in .npz (a GLB: --also X.glb)")
    also = None if options.also is None else check_writable(options.also)
    if also is not None and also.suffix.lower() != ".glb":
        raise InputError(f"--also {also}: expected a name that ends in .glb")
    read = [type(path)(name).resolve() for name in (*options.photos, *(options.landmarks or ()))]
    for each in (path, also):
        if each is not None and each.resolve() in read:
            raise InputError(f"{each} is both read and written: give the output another name")
    return path, also


def _check_numbers(options: argparse.Namespace) -> None:
    from mien.core.errors import InputError

    if options.eye_distance is not None and not 20 <= options.eye_distance <= 120:
        raise InputError(f"--eye-distance lies between 20 and 120 mm, not {options.eye_distance:g}")
    if not 0 <= options.even_light <= 1:
        raise InputError(f"--even-light lies between 0 and 1, not {options.even_light:g}")
    if not 256 <= options.texture_size <= 4096 or options.texture_size % 4:
        raise InputError(f"--texture-size is a multiple of 4 from 256 to 4096, not {options.texture_size}")


def _photos(names: Sequence[str], landmarks: Sequence[str] | None) -> list[Photo]:
    from mien.core.errors import InputError
    from mien.fit.mesh_files import read_picture
    from mien.fit.photo_marks import marks_from_file, marks_from_tracker

    if landmarks is not None and len(landmarks) != len(names):
        raise InputError(f"--landmarks: {len(landmarks)} files for {len(names)} photographs; give one for each, or '-'")
    photos = []
    for number, name in enumerate(names):
        picture = read_picture(name)
        if min(picture.shape[:2]) < 64:
            raise InputError(f"{name}: {picture.shape[1]} x {picture.shape[0]} pixels are too few; 64 at least")
        given = landmarks[number] if landmarks is not None else _beside(name)
        if given is None or given == "-":
            photos.append(marks_from_tracker(name, picture))
        else:
            photos.append(marks_from_file(name, picture, given))
    return photos


def _beside(name: str) -> str | None:
    """A file of landmarks with the photograph's name."""
    from pathlib import Path

    found = [path for suffix in (".csv", ".json", ".toml") if (path := Path(name).with_suffix(suffix)).is_file()]
    return str(found[0]) if found else None


def _report(done: PhotoFace, photos: Sequence[Photo]) -> str:
    lines = []
    for photo, camera, left in zip(photos, done.fit.cameras, done.fit.residuals, strict=True):
        height, width, _ = photo.picture.shape
        film = 36 * camera.focal / max(width, height)
        lines.append(
            f"{photo.name}: {width} x {height}, points: {len(photo.vertices)}, seen from {camera.yaw():+.0f} degrees "
            f"(+: the person's left), like a {film:.0f} mm lens on 36 mm film; points left {left:.1f} pixels off"
        )
    lines += [f"{note.kind}: {note.message}" for note in done.notes]
    return "\n".join(lines)
