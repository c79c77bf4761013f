"""``mien face make``: a face from a few facts and a seed, or between two of the cast; the sheet of ``mien faces``."""

from __future__ import annotations

import argparse
from pathlib import Path
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from mien.face.cast.made_person import Person

__all__ = ["add_command", "write_sheet"]

_NUMBERS = {
    "tone": "tone of the skin, from 0 (fair) to 1 (dark)",
    "grey": "share of grey hair, 0..1",
    "freckles": "0..1",
    "brows": "how thick, 0..1.3",
    "weight": "-1 thin .. 1 heavy",
    "muscle": "-1 weak .. 1 strong",
    "variety": "how unusual the features may be, 0..2 (default 1)",
}
_NAMES = {
    "hair": "cut of hair",
    "hair-colour": "",
    "beard": "'' for none",
    "eyes": "their colour",
    "shirt": "its colour",
}
_SUFFIXES = (".npz", ".glb", ".png")


def add_command(kinds: Any) -> None:
    """Add ``mien face make`` to the face commands."""
    parser = kinds.add_parser(
        "make",
        help="make a face from age, sex, origin and a seed, or blend two of the cast",
        description="Make a face from what you specify; the rest is drawn from the seed.",
    )
    parser.add_argument(
        "-o", "--output", required=True, metavar="X.npz|X.glb|X.png", help="the face, or a picture of it"
    )
    parser.add_argument("--also", action="append", default=[], metavar="X", help="one more output (repeatable)")
    parser.add_argument("--sex", metavar="f|m")
    parser.add_argument("--age", metavar="YEARS", help="14 to 95")
    parser.add_argument("--origin", metavar="NAME", help="such as african, asian, european ('?' lists all)")
    parser.add_argument("--seed", default="0", metavar="N", help="decides everything you leave out (default 0)")
    for name, what in _NAMES.items():
        parser.add_argument(f"--{name}", metavar="NAME", help=f"{what} ('?' lists all)".strip())
    for name, what in _NUMBERS.items():
        parser.add_argument(f"--{name}", metavar="NUMBER", help=what)
    parser.add_argument(
        "--feature", action="append", default=[], metavar="NAME=0..1", help="such as nose-width1-incr=0.6 (repeatable)"
    )
    parser.add_argument("--blend", metavar="NAME+NAME[:0..1]", help="blend two of the cast; nothing else is varied")
    parser.set_defaults(run=_make)


def _make(options: argparse.Namespace) -> int:
    from mien.core.errors import InputError
    from mien.core.files import check_writable
    from mien.face.cast.stored import face_of_person

    paths = [check_writable(path) for path in (options.output, *options.also)]
    for path in paths:
        if path.suffix.lower() not in _SUFFIXES:
            raise InputError(f"{path}: a made face is written as {', '.join(_SUFFIXES)}")
    person = _person(options, paths[0].stem)
    face = face_of_person(person)
    for path in paths:
        _write(face, path)
        print(f"{path}: {person.summary}, seed {person.seed}")
    return 0


def _person(options: argparse.Namespace, name: str) -> Person:
    from dataclasses import replace

    from mien.core.errors import InputError
    from mien.face.cast.made_person import is_blend, made_up, person_called

    own: dict[str, Any] = {key: _number(f"--{key}", getattr(options, key)) for key in _NUMBERS if getattr(options, key)}
    own |= {key: value for key in ("hair", "hair_colour", "beard", "eyes", "shirt")
            if (value := getattr(options, key)) is not None}  # fmt: skip
    features = [text.partition("=") for text in options.feature]
    if features:
        own["features"] = {feature: _number(f"--feature {feature}", value) for feature, _, value in features}
    if options.blend is not None:
        if own or options.sex or options.age or options.origin or options.seed != "0":
            raise InputError("--blend is between two of the cast: leave out what else a face is made from")
        if not is_blend(options.blend):
            raise InputError(
                f"--blend: expected NAME+NAME[:0..1] of the cast, such as amara+mei:0.3; got {options.blend!r}"
            )
        return replace(person_called(options.blend), name=name)
    try:
        seed = int(options.seed)
    except ValueError:
        raise InputError(f"--seed: expected a whole number of 0 or more, not {options.seed!r}") from None
    age = None if options.age is None else _number("--age", options.age)
    return made_up(options.sex, age, options.origin, seed, name, **own)


def _number(what: str, text: str) -> float:
    from mien.core.errors import InputError

    try:
        value = float(text)
    except ValueError:
        value = float("nan")
    if value != value or abs(value) > 1e6:
        raise InputError(f"{what}: expected a number, not {text!r}")
    return value


def _write(face: Any, path: Path) -> None:
    from PIL import Image

    from mien.cli.face_fit_command import write_rest
    from mien.core.files import replace_when_complete
    from mien.face.storage import write_face

    suffix = path.suffix.lower()
    if suffix == ".npz":
        write_face(face, path)
    elif suffix == ".glb":
        write_rest(face, path)
    else:
        with replace_when_complete(path) as unfinished:
            Image.fromarray(_portrait(face, 720, 900)).save(unfinished, "PNG")


def _portrait(face: Any, width: int, height: int) -> Any:
    from mien.face.posing import Poser
    from mien.face.render.camera import Camera
    from mien.face.render.renderer import Renderer

    renderer = Renderer(face, width, height, Camera.portrait(face, width / height))
    return renderer.render(Poser(face, ()).pose(()))


def write_sheet(path: str) -> None:
    """Draw all faces that come with mien on one sheet."""
    from PIL import Image

    from mien.cli.progress_bar import progress_bar
    from mien.core.files import check_writable, replace_when_complete
    from mien.face.library import known_faces, load_face
    from mien.formats.contact_sheet import contact_sheet

    target = check_writable(path)
    pictures = []
    with progress_bar("faces", "faces") as progress:
        for number, name in enumerate(known_faces()):
            pictures.append(_portrait(load_face(name), 300, 340))
            progress(number + 1, len(known_faces()))
    with replace_when_complete(target) as unfinished:
        Image.fromarray(contact_sheet(pictures, list(known_faces()), 6)).save(unfinished, "PNG")
