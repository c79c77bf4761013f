"""Every reader of mien, with sound files to begin from.

A target reads one file. What it raises on purpose is a `MienError`; anything else is a fault.
"""

from __future__ import annotations

import io
import json
import zipfile
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from fractions import Fraction
from importlib import resources
from pathlib import Path

import numpy as np

from mien.animation.animation import imported
from mien.core.audio import Audio
from mien.core.channels import ALL
from mien.core.timeline import FrameRate, Interval, Tier
from mien.core.tracks import ChannelTrack, MarkerTrack

__all__ = ["TARGETS", "Target"]

ASSETS = Path(str(resources.files("mien") / "assets"))
RATE = FrameRate.of(30)


@dataclass(frozen=True)
class Target:
    """One reader.

    Attributes
    ----------
    name : str
    suffix : str
        Of the files that it is given.
    read : callable
    seeds : callable
        Makes sound files in a folder and returns them.
    """

    name: str
    suffix: str
    read: Callable[[Path], object]
    seeds: Callable[[Path], Sequence[Path | bytes]]


def _lines(*texts: str) -> Callable[[Path], Sequence[bytes]]:
    return lambda folder: [text.encode() for text in texts]


def _of_assets(pattern: str, most: int = 60_000) -> Callable[[Path], Sequence[bytes]]:
    return lambda folder: [p.read_bytes() for p in sorted(ASSETS.glob(pattern)) if p.stat().st_size <= most]


def _moved(names: Sequence[str] = ALL, frames: int = 40) -> ChannelTrack:
    return ChannelTrack(tuple(names), np.random.default_rng(0).uniform(0, 0.4, (frames, len(names))), RATE)


def _tone(seconds: float = 0.4, rate: int = 8000) -> np.ndarray:
    return 0.4 * np.sin(2 * np.pi * 300 * np.arange(int(seconds * rate)) / rate)


def _sounds(folder: Path) -> list[Path]:
    import av
    import soundfile

    made = []
    for suffix, subtype in (
        ("wav", "PCM_16"), ("wav", "FLOAT"), ("wav", "GSM610"), ("wav", "IMA_ADPCM"), ("wav", "MS_ADPCM"), ("wav", "ULAW"),
        ("flac", "PCM_16"), ("ogg", "VORBIS"), ("aiff", "PCM_24"), ("au", "PCM_16"), ("caf", "ALAC_16"), ("w64", "PCM_16"),
        ("mp3", "MPEG_LAYER_III"), ("rf64", "PCM_16"), ("voc", "PCM_16"), ("nist", "PCM_16"),
    ):  # fmt: skip
        path = folder / f"{subtype}.{suffix}"
        soundfile.write(path, _tone(), 8000, subtype=subtype, format=suffix.upper())
        made.append(path)
    for suffix, codec in (("m4a", "aac"), ("mkv", "aac"), ("ogg", "libopus")):
        path = folder / f"{codec}.{suffix}"
        with av.open(str(path), "w") as container:
            stream = container.add_stream(codec, rate=48000, layout="mono")
            frame = av.AudioFrame.from_ndarray(_tone(rate=48000).astype(np.float32)[None], format="fltp", layout="mono")
            frame.sample_rate = 48000
            change = av.AudioResampler(stream.format, stream.layout, stream.rate, frame_size=stream.frame_size or None)
            for piece in [*change.resample(frame), *change.resample(None)]:
                container.mux(stream.encode(piece))
            container.mux(stream.encode(None))
        made.append(path)
    return made


def _videos(folder: Path) -> list[Path]:
    from mien.formats.video import write_frames

    pictures = np.random.default_rng(0).integers(0, 255, (8, 48, 64, 3), dtype=np.uint8)
    write_frames(iter(pictures), Fraction(25), Audio(_tone(0.3, 16000), 16000), str(folder / "a.mp4"), (64, 48))
    return [folder / "a.mp4"]


def _read_video(path: Path) -> None:
    from mien.corpus.readers.video_recordings import steady_frames

    _, _, frames = steady_frames(path, 0.0)
    for number, _ in enumerate(frames):
        if number > 100:
            break


def _pictures(folder: Path) -> list[bytes]:
    from PIL import Image

    picture, made = Image.fromarray(np.random.default_rng(0).integers(0, 255, (20, 30, 3), dtype=np.uint8)), []
    for kind in ("PNG", "JPEG", "WEBP", "GIF", "BMP", "TIFF", "TGA", "PPM", "ICO"):
        stream = io.BytesIO()
        picture.save(stream, kind)
        made.append(stream.getvalue())
    return made


def _read_picture(path: Path) -> None:
    from mien.fit.mesh_files import read_picture

    read_picture(path)


def _beat(folder: Path) -> list[Path]:
    frames = [{"weights": [k / 9, 0.5], "time": k / 60, "rotation": []} for k in range(10)]
    (folder / "a.json").write_text(json.dumps({"names": ["browDownLeft", "jawOpen"], "frames": frames}))
    return [folder / "a.json"]


def _livelink(folder: Path) -> list[Path]:
    from mien.formats.livelink import write_livelink

    write_livelink(imported(_moved(), "x"), folder / "a.csv")
    text = (folder / "a.csv").read_text(encoding="utf-8")
    (folder / "b.csv").write_text(text.replace(".", "§").replace(",", ";").replace("§", ","), encoding="utf-8")
    return [folder / "a.csv", folder / "b.csv"]


def _native(folder: Path) -> list[Path]:
    from mien.formats.native import write_native

    write_native(imported(_moved(frames=4), "x"), folder / "a.json")
    return [folder / "a.json"]


def _layers(folder: Path) -> list[Path]:
    from mien.animation.edits.layer import EditLayer
    from mien.animation.edits.layer_file import write_layer

    write_layer(EditLayer(), folder / "a.json")
    return [folder / "a.json"]


def _faps(folder: Path) -> list[Path]:
    from mien.face.library import load_face
    from mien.formats.fap import write_fap

    write_fap(imported(_moved(frames=5), "x"), load_face(), folder / "a.fap")
    return [folder / "a.fap"]


def _grids(folder: Path) -> list[Path]:
    from mien.formats.textgrid import write_textgrid

    words = Tier("words", (Interval(0.1, 0.3, 'he"llo'), Interval(0.4, 0.5, "ä")))
    phones = Tier("phones", (Interval(0.1, 0.2, "HH"), Interval(0.2, 0.3, "OW"), Interval(0.4, 0.5, "EH")))
    write_textgrid((words, phones), 0.6, folder / "a.TextGrid")
    text = (folder / "a.TextGrid").read_text(encoding="utf-8")
    (folder / "b.TextGrid").write_text(text, encoding="utf-16")
    return [folder / "a.TextGrid", folder / "b.TextGrid"]


def _markers() -> MarkerTrack:
    places = np.random.default_rng(0).uniform(-50, 50, (6, 3, 3))
    return MarkerTrack(("a", "b", "c"), places, RATE)


def _marker_archives(folder: Path) -> list[Path]:
    track = _markers()
    names = np.array(track.names)
    np.savez(folder / "a.npz", markers=track.positions, names=names, fps=30.0)
    np.savez_compressed(
        folder / "b.npz", markers=track.positions, names=names, rate=np.array([30, 1]), units=np.array("mm")
    )
    return [folder / "a.npz", folder / "b.npz"]


def _marker_tables(folder: Path) -> list[bytes]:
    track = _markers()
    rows = [",".join(["time", *(f"{name}_{axis}" for name in track.names for axis in "xyz")])]
    rows += [",".join([f"{i / 30:.5f}", *(f"{v:.3f}" for v in row.ravel())]) for i, row in enumerate(track.positions)]
    return ["\n".join(rows).encode()]


def _c3d(folder: Path) -> list[Path]:
    import ezc3d

    file, made = ezc3d.c3d(), []
    track = _markers()
    file["parameters"]["POINT"]["RATE"]["value"] = [30.0]
    file["parameters"]["POINT"]["LABELS"]["value"] = list(track.names)
    points = np.ones((4, 3, 6))
    points[:3] = track.positions.transpose(2, 1, 0)
    file["data"]["points"] = points
    file.write(str(folder / "a.c3d"))
    made.append(folder / "a.c3d")
    return made


def _recording(name: str) -> Callable[[Path], object]:
    def read(path: Path) -> object:
        from mien.corpus.readers import Found, reader_named
        from mien.corpus.recipes import Recipe

        return reader_named(name).read(Found(path.stem, path), Recipe("x", "x", name))

    return read


def _small_faces(folder: Path) -> list[Path]:
    from mien.face.model import Face, Material, Part, Target
    from mien.face.storage import write_face

    count = 12
    random = np.random.default_rng(0)
    part = Part(
        "skin", random.uniform(-9, 9, (count, 3)).astype(np.float32), np.arange(count, dtype=np.int32).reshape(-1, 3),
        np.zeros((count, 2), np.float32), np.ones((count, 3), np.float32),
        Material("skin", (0.8, 0.6, 0.5), texture=np.zeros((8, 8, 3), np.uint8)), np.ones(count, np.float32),
        {"jawOpen": Target(np.arange(3, dtype=np.int32), np.ones((3, 3), np.float32))},
    )  # fmt: skip
    write_face(Face("x", (part,), (), (0.0, 0.0, 0.0), {"chin": ("skin", 1)}, "none"), folder / "a.npz")
    return [folder / "a.npz"]


TREE = """mien-tree 1
parameter head
  rotation axis 0 1 0 pivot 0 0 0
  group skeletal
  drive headYaw 1
  all 1
parameter jaw
  translation 0 -20 0
  parent head
  drive jawOpen 1
  sphere 0 -50 50 radius 40 soft 60
"""
OBJ = "mtllib a.mtl\nv 0 0 0 1 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nvt 0 0\nvt 1 1\nf 1/1 2/2 3/1 4/2\nf -1 -2 -3\n"
PLY = (
    "ply\nformat ascii 1.0\nelement vertex 4\nproperty float x\nproperty float y\nproperty float z\nelement face 1\n"
    "property list uchar int vertex_indices\nend_header\n0 0 0\n1 0 0\n1 1 0\n0 1 0\n4 0 1 2 3\n"
)


def _binary_ply(folder: Path) -> list[bytes]:
    head = PLY.split("end_header")[0].replace("ascii", "binary_little_endian") + "end_header\n"
    body = (
        np.array([0, 0, 0, 1, 0, 0, 1, 1, 0, 0, 1, 0], "<f4").tobytes() + b"\x04" + np.arange(4, dtype="<i4").tobytes()
    )
    return [PLY.encode(), head.encode() + body]


def _zoo(folder: Path) -> list[Path]:
    from tests.zoo import ZOO

    made = []
    for number, maker in enumerate(ZOO.values()):
        place = folder / str(number)
        place.mkdir(parents=True)
        path = maker(place).path
        if path.suffix in (".glb", ".vrm"):
            made.append(path)
    return made


def _text_zoo(folder: Path) -> list[Path]:
    from tests.zoo import ZOO

    made = []
    for number, maker in enumerate(ZOO.values()):
        place = folder / f"t{number}"
        place.mkdir(parents=True)
        path = maker(place).path
        if path.suffix == ".gltf":
            made.append(path)
    return made


def _read_foreign(path: Path) -> None:
    from mien.face.foreign.recognition import foreign_face

    foreign_face(path)


def _draw_foreign(path: Path) -> None:
    from mien.face.foreign.drawn import drawn_face
    from mien.face.foreign.recognition import foreign_face

    drawn_face(foreign_face(path))


def _mesh(path: Path) -> None:
    from mien.fit.mesh_files import read_mesh

    read_mesh(path)


def _call(module: str, name: str, *more: object) -> Callable[[Path], object]:
    """A reader by its place, loaded when it is needed."""

    def read(path: Path) -> object:
        from importlib import import_module

        return getattr(import_module(module), name)(path, *more)

    return read


def _script(path: Path) -> None:
    from mien.text.script_reading import read_script_file

    read_script_file(path)


def _spoken(path: Path) -> None:
    from mien.pipeline.text_inputs import read_text
    from mien.text.normalisation import spoken_words

    spoken_words(read_text(path))


def _messages(path: Path) -> None:
    from mien.serve.modules.messages import Messages

    messages = Messages({"HeadNod", "Smile"}, texts=True)
    for line in path.read_text(encoding="utf-8", errors="replace").split("\n"):
        messages.take(line)
    messages.finish()


def _by_name(module: str, name: str) -> Callable[[Path], object]:
    def read(path: Path) -> object:
        from importlib import import_module

        return getattr(import_module(module), name)(str(path))

    return read


def _stream(path: Path) -> None:
    from mien.serve.live.frames import Greeting, decode_frame

    content = path.read_bytes()
    if content[:1] == b"{":
        Greeting.decode(content.decode("utf-8", errors="replace"))
    else:
        decode_frame(content)


def _stream_messages(folder: Path) -> list[bytes]:
    from mien.serve.live.frames import Frame, Greeting, encode_frame

    return [
        Greeting(("jawOpen", "tongueOut"), 30.0, {"text": "x"}).encode().encode(),
        encode_frame(Frame(3, 0.1, np.zeros(2))),
    ]


def _sound_text(path: Path) -> None:
    from mien.formats.sound_text import decode_audio

    decode_audio(path.read_bytes().decode("latin-1"), 8000, 3200)


def _sound_texts(folder: Path) -> list[bytes]:
    from mien.formats.sound_text import encode_audio

    return [encode_audio(Audio(_tone(), 8000)).encode()]


def _learned(folder: Path) -> list[bytes]:
    return [(ASSETS / "emotions" / "voice.npz").read_bytes()]


def _performers(folder: Path) -> list[Path]:
    """The default performer without its graph, which is read when it is used."""
    from mien.motion.performer_file import PREFIX

    with (
        zipfile.ZipFile(ASSETS / "performers" / "default.mien") as whole,
        zipfile.ZipFile(folder / "a.mien", "w") as small,
    ):
        for member in whole.infolist():
            if not member.filename.startswith(PREFIX):
                small.writestr(member.filename, whole.read(member), zipfile.ZIP_DEFLATED)
    return [folder / "a.mien"]


def _table_of(folder: str, read: Callable[[], object]) -> Callable[[Path], object]:
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


def _light(path: Path) -> object:
    from mien.face.render.lighting import Lighting

    return Lighting.named(str(path))


def _own_emotion() -> object:
    from mien.core.emotions import emotions

    emotions.cache_clear()
    return emotions()


def _own_person() -> object:
    from mien.face.cast.made_person import person_named

    return person_named("mine")


def _project(path: Path) -> object:
    from mien.serve.studio.journal import Journal
    from mien.serve.studio.projects import read_project
    from mien.serve.studio.settings import Limits
    from mien.serve.studio.studio_faces import FaceShelf

    limits, folder = Limits(), path.parent / "kept"
    return read_project(path.read_bytes(), Journal(folder, limits), FaceShelf(folder / "faces", limits), limits)


def _journal(path: Path) -> object:
    from mien.serve.studio.journal import Journal
    from mien.serve.studio.settings import Limits

    folder = path.parent / "journal"
    (folder / "takes").mkdir(parents=True, exist_ok=True)
    (folder / "takes" / "abcdefgh.jsonl").write_bytes(path.read_bytes())
    return Journal(folder, Limits())


_STEP = {
    "request": {"text": "Hello.", "emotion": "happy:0.5"},
    "layer": {"format": "mien-edits", "version": 1, "edits": []},
    "sound": None,
}
_TAKE = {"name": "a", "made": 1.5, "steps": [_STEP], "at": 0}
_LINES = (_TAKE, {"keep": 1, "add": [_STEP], "at": 1}, {"name": "b"})


def _projects(folder: Path) -> list[bytes]:
    stream = io.BytesIO()
    told = {"format": "mien-project", "version": 1, "takes": {"abcdefgh": _TAKE}, "page": {"zoom": 1}}
    with zipfile.ZipFile(stream, "w", zipfile.ZIP_DEFLATED) as archive:
        archive.writestr("project.json", json.dumps(told))
    return [stream.getvalue()]


def _stl(folder: Path) -> list[bytes]:
    corners = np.arange(24, dtype="<f4").reshape(2, 12)
    body = b"".join(row.tobytes() + b"\0\0" for row in corners)
    text = "solid x\nfacet normal 0 0 1\nouter loop\n" + "vertex 0 1 2\n" * 3 + "endloop\nendfacet\nendsolid x\n"
    return [bytes(80) + b"\2\0\0\0" + body, text.encode()]


SCRIPT = (
    'I <emotion name="happy:0.5">never</emotion> said <HeadNod count="2"/> that. <break time="300ms"/> 3 < 4 &amp; '
    '<prosody rate="slow">Maybe</prosody> <phoneme alphabet="ipa" ph="ˈpiːpəl">people</phoneme> <mark name="m1"/>'
    '<curve parameter="jawOpen"><key at="0" value="0.1"/><key at="m1" value="0.5"/></curve> heard!'
)
SSML = f'<?xml version="1.0"?>\n<speak version="1.1" xml:lang="en">{SCRIPT.replace("3 < 4", "x")}</speak>'
BML = (
    '<bml id="b1" xmlns="http://www.bml-initiative.org/bml/bml-1.0"><speech id="s1"><text>Hello <sync id="t1"/> there.'
    '</text></speech><head id="h1" lexeme="NOD" start="s1:t1" repetition="2"/><faceLexeme id="f1" lexeme="smile" '
    'start="s1:start+0.2" end="s1:end" amount="0.5"/><gaze id="g1" target="left" start="0.1"/></bml>'
)
TEXT = (
    "Dr. Smith paid $3.50 on March 5, 2024 at 10:30 p.m.; 24/7, AT&T, XIV, www.a-b.com, 1/2, 5'11\", (555) 123-4567 #1!"
)

TARGETS: tuple[Target, ...] = (
    Target("script", ".txt", _script, _lines(SCRIPT, TEXT)),
    Target("ssml", ".ssml", _script, _lines(SSML)),
    Target("bml", ".bml", _script, _lines(BML)),
    Target("spoken", ".txt", _spoken, _lines(TEXT, SCRIPT)),
    Target("messages", ".txt", _messages, _lines(SCRIPT, SSML, '<HeadNod at="1"\ncount="2">\n<!-- a\n-->\n<Smile/>\n')),
    Target("commands", ".txt", _call("mien.text.library_file", "read_library_file"), _of_assets("commands/*.txt")),
    Target("intensity", ".csv", _call("mien.text.intensity", "read_intensity"), _lines("seconds,happy\n0,0.1\n1,0.9\n2.5,0\n")),
    Target(
        "expression parameters", ".csv", _call("mien.text.expression_parameters", "read_expression_parameters"),
        _lines("seconds,expression1,intensity1,expression2,intensity2\n0,joy,30,,\n0.5,joy,60,sadness,3\n"),
    ),
    Target("language", ".toml", _by_name("mien.text.languages.language", "find_language"), _of_assets("languages/*.toml")),
    Target("textgrid", ".TextGrid", _call("mien.formats.textgrid", "read_textgrid"), _grids),
    Target("transcript grid", ".TextGrid", _call("mien.corpus.transcripts", "read_transcript"), _grids),
    Target("transcript lab", ".lab", _call("mien.corpus.transcripts", "read_transcript"), _lines("0 1000000 hello\n1000000 2000000 there\n")),
    Target("transcript align", ".align", _call("mien.corpus.transcripts", "read_transcript"), _lines("0 23750 sil\n23750 29500 bin\n")),
    Target("table", ".csv", _call("mien.corpus.transcripts", "read_table"), _lines('name,text,emotion\na,"Hello, you",happy\nb;,x,\n')),
    Target("list", ".txt", _call("mien.metrics.splits", "read_list", "takes"), _lines("a b # c\nd\n")),
    Target("design", ".csv", _call("mien.api.stimuli.design", "read_design"), _lines("name,sentence,emotion,intensity\na,Hello.|Bye.,happy|sad,0.5|1\n")),
    Target("livelink", ".csv", _call("mien.formats.livelink", "read_livelink"), _livelink),
    Target("livelink recording", ".csv", _recording("livelink"), _livelink),
    Target("native", ".json", _call("mien.formats.native", "read_native"), _native),
    Target("layer", ".json", _call("mien.animation.edits.layer_file", "read_layer"), _layers),
    Target("fap", ".fap", _call("mien.formats.fap", "read_fap"), _faps),
    Target("beat recording", ".json", _recording("beat"), _beat),
    Target("marker table", ".csv", _recording("tracks"), _marker_tables),
    Target("marker archive", ".npz", _recording("tracks"), _marker_archives),
    Target("c3d", ".c3d", _recording("c3d"), _c3d),
    Target("sound", ".wav", _call("mien.formats.sound_files", "read_audio"), _sounds),
    Target("sound text", ".txt", _sound_text, _sound_texts),
    Target("video", ".mp4", _read_video, _videos),
    Target("picture", ".png", _read_picture, _pictures),
    Target("obj", ".obj", _mesh, _lines(OBJ)),
    Target("ply", ".ply", _mesh, _binary_ply),
    Target("bare glb", ".glb", _mesh, _zoo),
    Target("foreign glb", ".glb", _read_foreign, _zoo),
    Target("foreign gltf", ".gltf", _read_foreign, _text_zoo),
    Target("drawn glb", ".glb", _draw_foreign, _zoo),
    Target("face", ".npz", _call("mien.face.storage", "read_face"), _small_faces),
    Target("tree", ".tree", _call("mien.face.tree_config", "read_tree"), _lines(TREE)),
    Target("landmarks csv", ".csv", _call("mien.fit.landmarks", "read_landmarks", 1), _lines("name,vertex\nnose_tip,3\nchin,4\n")),
    Target("landmarks json", ".json", _call("mien.fit.landmarks", "read_landmarks", 3), _lines('{"nose_tip": [1, 2, 3], "chin": [0, 0, 1]}')),
    Target("names", ".toml", _call("mien.face.foreign.rig_names", "own_names"), _lines('faces = "+z"\n[targets]\njawOpen = "Mouth"\n[eyes]\nUp = 20\n')),
    Target("recipe", ".toml", _by_name("mien.corpus.recipes", "load_recipe"), _of_assets("recipes/*.toml")),
    Target("layout", ".toml", _by_name("mien.capture.layouts", "load_layout"), _of_assets("markers/*.toml")),
    Target("classifier", ".npz", _call("mien.emotion.emotion_classifier", "load_classifier"), _learned),
    Target("performer", ".mien", _call("mien.motion.performer_file", "load_learned"), _performers),
    Target("stl", ".stl", _mesh, _stl),
    Target("camera", ".toml", _call("mien.face.render.camera", "camera_table"), _of_assets("render/cameras/*.toml")),
    Target("light", ".toml", _light, _of_assets("render/lights/*.toml")),
    Target("emotion", ".toml", _table_of("performance/emotions", _own_emotion), _of_assets("performance/emotions/*.toml")),
    Target("person", ".toml", _table_of("faces/cast", _own_person), _of_assets("faces/cast/*.toml")),
    Target("project", ".zip", _project, _projects),
    Target("journal", ".jsonl", _journal, _lines("\n".join(map(json.dumps, _LINES)))),
    Target("stream", ".bin", _stream, _stream_messages),
)  # fmt: skip
