"""Whole, undamaged files of every kind that mien reads, for the fuzzer to begin from."""

from __future__ import annotations

import io
import json
import zipfile
from collections.abc import Callable, Sequence
from fractions import Fraction
from importlib import resources
from pathlib import Path

import numpy as np

from mien.animation.animation import imported
from mien.core.audio import Audio
from mien.core.channels import ALL
from mien.core.timeline import FrameRate, Interval, Tier
from mien.core.tracks import ChannelTrack, MarkerTrack

ASSETS = Path(str(resources.files("mien") / "assets"))


RATE = FrameRate.of(30)


def lines(*texts: str) -> Callable[[Path], Sequence[bytes]]:
    return lambda folder: [text.encode() for text in texts]


def of_assets(pattern: str, most: int = 60_000) -> Callable[[Path], Sequence[bytes]]:
    return lambda folder: [p.read_bytes() for p in sorted(ASSETS.glob(pattern)) if p.stat().st_size <= most]


def moved(names: Sequence[str] = ALL, frames: int = 40) -> ChannelTrack:
    return ChannelTrack(tuple(names), np.random.default_rng(0).uniform(0, 0.4, (frames, len(names))), RATE)


def tone(seconds: float = 0.4, rate: int = 8000) -> np.ndarray:
    return 0.4 * np.sin(2 * np.pi * 300 * np.arange(int(seconds * rate)) / rate)


def sounds(folder: Path) -> list[Path]:
    import av
    import soundfile

    made = []
    for suffix, subtype in (
        ("wav", "PCM_16"), ("wav", "FLOAT"), ("wav", "GSM610"), ("wav", "IMA_ADPCM"), ("wav", "MS_ADPCM"), ("wav", "ULAW"),
        ("flac", "PCM_16"), ("ogg", "VORBIS"), ("aiff", "PCM_24"), ("au", "PCM_16"), ("caf", "ALAC_16"), ("w64", "PCM_16"),
        ("mp3", "MPEG_LAYER_III"), ("rf64", "PCM_16"), ("voc", "PCM_16"), ("nist", "PCM_16"),
    ):  # fmt: skip
        path = folder / f"{subtype}.{suffix}"
        soundfile.write(path, tone(), 8000, subtype=subtype, format=suffix.upper())
        made.append(path)
    for suffix, codec in (("m4a", "aac"), ("mkv", "aac"), ("ogg", "libopus")):
        path = folder / f"{codec}.{suffix}"
        with av.open(str(path), "w") as container:
            stream = container.add_stream(codec, rate=48000, layout="mono")
            frame = av.AudioFrame.from_ndarray(tone(rate=48000).astype(np.float32)[None], format="fltp", layout="mono")
            frame.sample_rate = 48000
            change = av.AudioResampler(stream.format, stream.layout, stream.rate, frame_size=stream.frame_size or None)
            for piece in [*change.resample(frame), *change.resample(None)]:
                container.mux(stream.encode(piece))
            container.mux(stream.encode(None))
        made.append(path)
    return made


def videos(folder: Path) -> list[Path]:
    from mien.formats.video import write_frames

    pictures = np.random.default_rng(0).integers(0, 255, (8, 48, 64, 3), dtype=np.uint8)
    write_frames(iter(pictures), Fraction(25), Audio(tone(0.3, 16000), 16000), str(folder / "a.mp4"), (64, 48))
    return [folder / "a.mp4"]


def pictures(folder: Path) -> list[bytes]:
    from PIL import Image

    picture, made = Image.fromarray(np.random.default_rng(0).integers(0, 255, (20, 30, 3), dtype=np.uint8)), []
    for kind in ("PNG", "JPEG", "WEBP", "GIF", "BMP", "TIFF", "TGA", "PPM", "ICO"):
        stream = io.BytesIO()
        picture.save(stream, kind)
        made.append(stream.getvalue())
    return made


def beat(folder: Path) -> list[Path]:
    frames = [{"weights": [k / 9, 0.5], "time": k / 60, "rotation": []} for k in range(10)]
    (folder / "a.json").write_text(json.dumps({"names": ["browDownLeft", "jawOpen"], "frames": frames}))
    return [folder / "a.json"]


def livelink(folder: Path) -> list[Path]:
    from mien.formats.livelink import write_livelink

    write_livelink(imported(moved(), "x"), folder / "a.csv")
    text = (folder / "a.csv").read_text(encoding="utf-8")
    (folder / "b.csv").write_text(text.replace(".", "§").replace(",", ";").replace("§", ","), encoding="utf-8")
    return [folder / "a.csv", folder / "b.csv"]


def native(folder: Path) -> list[Path]:
    from mien.formats.native import write_native

    write_native(imported(moved(frames=4), "x"), folder / "a.json")
    return [folder / "a.json"]


def layers(folder: Path) -> list[Path]:
    from mien.animation.edits.layer import EditLayer
    from mien.animation.edits.layer_file import write_layer

    write_layer(EditLayer(), folder / "a.json")
    return [folder / "a.json"]


def faps(folder: Path) -> list[Path]:
    from mien.face.library import load_face
    from mien.formats.fap import write_fap

    write_fap(imported(moved(frames=5), "x"), load_face(), folder / "a.fap")
    return [folder / "a.fap"]


def grids(folder: Path) -> list[Path]:
    from mien.formats.textgrid import write_textgrid

    words = Tier("words", (Interval(0.1, 0.3, 'he"llo'), Interval(0.4, 0.5, "ä")))
    phones = Tier("phones", (Interval(0.1, 0.2, "HH"), Interval(0.2, 0.3, "OW"), Interval(0.4, 0.5, "EH")))
    write_textgrid((words, phones), 0.6, folder / "a.TextGrid")
    text = (folder / "a.TextGrid").read_text(encoding="utf-8")
    (folder / "b.TextGrid").write_text(text, encoding="utf-16")
    return [folder / "a.TextGrid", folder / "b.TextGrid"]


def markers() -> MarkerTrack:
    places = np.random.default_rng(0).uniform(-50, 50, (6, 3, 3))
    return MarkerTrack(("a", "b", "c"), places, RATE)


def marker_archives(folder: Path) -> list[Path]:
    track = markers()
    names = np.array(track.names)
    np.savez(folder / "a.npz", markers=track.positions, names=names, fps=30.0)
    np.savez_compressed(
        folder / "b.npz", markers=track.positions, names=names, rate=np.array([30, 1]), units=np.array("mm")
    )
    return [folder / "a.npz", folder / "b.npz"]


def marker_tables(folder: Path) -> list[bytes]:
    track = markers()
    rows = [",".join(["time", *(f"{name}_{axis}" for name in track.names for axis in "xyz")])]
    rows += [",".join([f"{i / 30:.5f}", *(f"{v:.3f}" for v in row.ravel())]) for i, row in enumerate(track.positions)]
    return ["\n".join(rows).encode()]


def c3d(folder: Path) -> list[Path]:
    import ezc3d

    file, made = ezc3d.c3d(), []
    track = markers()
    file["parameters"]["POINT"]["RATE"]["value"] = [30.0]
    file["parameters"]["POINT"]["LABELS"]["value"] = list(track.names)
    points = np.ones((4, 3, 6))
    points[:3] = track.positions.transpose(2, 1, 0)
    file["data"]["points"] = points
    file.write(str(folder / "a.c3d"))
    made.append(folder / "a.c3d")
    return made


def small_faces(folder: Path) -> list[Path]:
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


def binary_ply(folder: Path) -> list[bytes]:
    head = PLY.split("end_header")[0].replace("ascii", "binary_little_endian") + "end_header\n"
    body = (
        np.array([0, 0, 0, 1, 0, 0, 1, 1, 0, 0, 1, 0], "<f4").tobytes() + b"\x04" + np.arange(4, dtype="<i4").tobytes()
    )
    return [PLY.encode(), head.encode() + body]


def zoo(folder: Path) -> list[Path]:
    from tests.zoo import ZOO

    made = []
    for number, maker in enumerate(ZOO.values()):
        place = folder / str(number)
        place.mkdir(parents=True)
        path = maker(place).path
        if path.suffix in (".glb", ".vrm"):
            made.append(path)
    return made


def text_zoo(folder: Path) -> list[Path]:
    from tests.zoo import ZOO

    made = []
    for number, maker in enumerate(ZOO.values()):
        place = folder / f"t{number}"
        place.mkdir(parents=True)
        path = maker(place).path
        if path.suffix == ".gltf":
            made.append(path)
    return made


def stream_messages(folder: Path) -> list[bytes]:
    from mien.serve.live.frames import Frame, Greeting, encode_frame

    return [
        Greeting(("jawOpen", "tongueOut"), 30.0, {"text": "x"}).encode().encode(),
        encode_frame(Frame(3, 0.1, np.zeros(2))),
    ]


def sound_texts(folder: Path) -> list[bytes]:
    from mien.formats.sound_text import encode_audio

    return [encode_audio(Audio(tone(), 8000)).encode()]


def learned(folder: Path) -> list[bytes]:
    return [(ASSETS / "emotions" / "voice.npz").read_bytes()]


def performers(folder: Path) -> list[Path]:
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


STEP = {
    "request": {"text": "Hello.", "emotion": "happy:0.5"},
    "layer": {"format": "mien-edits", "version": 1, "edits": []},
    "sound": None,
}


TAKE = {"name": "a", "made": 1.5, "steps": [STEP], "at": 0}


LINES = (TAKE, {"keep": 1, "add": [STEP], "at": 1}, {"name": "b"})


def projects(folder: Path) -> list[bytes]:
    stream = io.BytesIO()
    told = {"format": "mien-project", "version": 1, "takes": {"abcdefgh": TAKE}, "page": {"zoom": 1}}
    with zipfile.ZipFile(stream, "w", zipfile.ZIP_DEFLATED) as archive:
        archive.writestr("project.json", json.dumps(told))
    return [stream.getvalue()]


def stl(folder: Path) -> list[bytes]:
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
