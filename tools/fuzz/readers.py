"""The readers that are fuzzed, each called with the path of one file; loaded when they are needed."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path


def read_video(path: Path) -> None:
    from mien.corpus.readers.video_recordings import steady_frames

    _, _, frames = steady_frames(path, 0.0)
    for number, _ in enumerate(frames):
        if number > 100:
            break


def read_picture(path: Path) -> None:
    from mien.fit.mesh_files import read_picture

    read_picture(path)


def recording(name: str) -> Callable[[Path], object]:
    def read(path: Path) -> object:
        from mien.corpus.readers import Found, reader_named
        from mien.corpus.recipes import Recipe

        return reader_named(name).read(Found(path.stem, path), Recipe("x", "x", name))

    return read


def read_foreign(path: Path) -> None:
    from mien.face.foreign.recognition import foreign_face

    foreign_face(path)


def draw_foreign(path: Path) -> None:
    from mien.face.foreign.drawn import drawn_face
    from mien.face.foreign.recognition import foreign_face

    drawn_face(foreign_face(path))


def mesh(path: Path) -> None:
    from mien.fit.mesh_files import read_mesh

    read_mesh(path)


def call(module: str, name: str, *more: object) -> Callable[[Path], object]:
    """A reader by its place, loaded when it is needed."""

    def read(path: Path) -> object:
        from importlib import import_module

        return getattr(import_module(module), name)(path, *more)

    return read


def script(path: Path) -> None:
    from mien.text.script_reading import read_script_file

    read_script_file(path)


def spoken(path: Path) -> None:
    from mien.pipeline.inputs import read_text
    from mien.text.normalisation import spoken_words

    spoken_words(read_text(path))


def messages(path: Path) -> None:
    from mien.serve.modules.messages import Messages

    messages = Messages({"HeadNod", "Smile"}, texts=True)
    for line in path.read_text(encoding="utf-8", errors="replace").split("\n"):
        messages.take(line)
    messages.finish()


def by_name(module: str, name: str) -> Callable[[Path], object]:
    def read(path: Path) -> object:
        from importlib import import_module

        return getattr(import_module(module), name)(str(path))

    return read


def stream(path: Path) -> None:
    from mien.serve.live.frames import Greeting, decode_frame

    content = path.read_bytes()
    if content[:1] == b"{":
        Greeting.decode(content.decode("utf-8", errors="replace"))
    else:
        decode_frame(content)


def sound_text(path: Path) -> None:
    from mien.formats.sound_text import decode_audio

    decode_audio(path.read_bytes().decode("latin-1"), 8000, 3200)


def table_of(folder: str, read: Callable[[], object]) -> Callable[[Path], object]:
    """A table of the user's own, where mien looks for such tables."""

    def read_own(path: Path) -> object:
        import os

        from mien.core import assets

        place = path.parent / "own" / folder / "mine.toml"
        place.parent.mkdir(parents=True, exist_ok=True)
        place.write_bytes(path.read_bytes())
        os.environ["MIEN_TABLES"] = str(path.parent / "own")
        assets._table.cache_clear()
        try:
            return read()
        finally:
            del os.environ["MIEN_TABLES"]

    return read_own


def light(path: Path) -> object:
    from mien.face.render.lighting import Lighting

    return Lighting.named(str(path))


def own_emotion() -> object:
    from mien.core.emotions import emotions

    emotions.cache_clear()
    return emotions()


def own_person() -> object:
    from mien.face.cast.made_person import person_named

    return person_named("mine")


def project(path: Path) -> object:
    from mien.serve.studio.journal import Journal
    from mien.serve.studio.projects import read_project
    from mien.serve.studio.settings import Limits
    from mien.serve.studio.studio_faces import FaceShelf

    limits, folder = Limits(), path.parent / "kept"
    return read_project(path.read_bytes(), Journal(folder, limits), FaceShelf(folder / "faces", limits), limits)


def journal(path: Path) -> object:
    from mien.serve.studio.journal import Journal
    from mien.serve.studio.settings import Limits

    folder = path.parent / "journal"
    (folder / "takes").mkdir(parents=True, exist_ok=True)
    (folder / "takes" / "abcdefgh.jsonl").write_bytes(path.read_bytes())
    return Journal(folder, Limits())
