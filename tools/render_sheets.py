"""Draw the sheets of pictures that the documentation shows: the face at rest, and every shape it can make.

::

    python tools/render_sheets.py --out docs/pictures
    python tools/render_sheets.py --out docs/pictures --only shapes

A sheet is one entry of `SHEETS`; every picture in it is a `Shot`.
"""

from __future__ import annotations

import argparse
import os
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field, replace
from pathlib import Path

import numpy as np
from numpy.typing import NDArray
from PIL import Image, ImageDraw

import mien
from mien.animation.animation import Animation
from mien.api.recoloring import recolor
from mien.core.channels import ALL, TONGUE, WEIGHTS
from mien.core.errors import unknown_name
from mien.core.facs import action_units, au_channels, basic_expressions, expression_channels
from mien.core.files import replace_when_complete
from mien.core.timeline import FrameRate
from mien.face.library import load_face
from mien.face.model import Face, Part
from mien.face.posing import Poser
from mien.face.render.camera import Camera
from mien.face.render.renderer import Renderer
from mien.motion.expression.hand_made_performance import hand_made_expression
from mien.motion.mouth.hand_made_mouth import HandMadeMouth
from mien.motion.performers import known_performers
from mien.text.phones import phone_table
from mien.text.score import EmotionSpan, Score

JPEG_QUALITY = 86
PERFORMERS_LINE = "We saw Bob move five blue ships"
PERFORMERS_PHONES = ("W", "AO", "B", "AA", "M", "F", "AY", "UW", "SH")
EFFORT_LINE, EFFORTS = "My father was five, boy!", (0.4, 1.0, 1.8)
EFFORT_PHONES = ("M", "AY", "AA", "W", "F", "OY")
AUTO = ("15b09Wb", "08a07Fd", "13a05Tc")
"""Voices of EmoDB that are angry, happy and sad, and surely so to the reader."""


@dataclass(frozen=True)
class Shot:
    """One picture: channel weights, and from where; ``framing`` is one of `FRAMINGS`, angles in degrees.

    ``cut`` takes away skin, teeth and clothes on the speaker's left (x > 0), so that the tongue is seen between them.
    """

    caption: str
    weights: Mapping[str, float] = field(default_factory=dict)
    framing: str = "portrait"
    yaw: float = 0.0
    pitch: float = 0.0
    cut: bool = False


@dataclass(frozen=True)
class Sheet:
    """Pictures in rows of ``columns``, each ``width`` by ``height`` pixels; ``shots`` is called when it is drawn."""

    shots: Callable[[], tuple[Shot, ...]]
    columns: int
    width: int
    height: int


# Height of what is seen (mm) and the height of its middle over the eyes (mm).
FRAMINGS = {
    "close": (178.0, -22.0),
    "portrait": (330.0, -30.0),
    "face": (235.0, -18.0),
    "mouth": (95.0, -62.0),
    "lips": (62.0, -66.0),
    "inside": (105.0, -62.0),
    "eyes": (80.0, 3.0),
}


def _companions(name: str) -> dict[str, float]:
    """What a shape is shown with, where it makes no sense alone."""
    with_jaw = {
        "mouthClose": 1.0,
        "tongueOut": 0.3,
        "tongueTipUp": 0.3,
        "tongueBackUp": 0.4,
        "tongueBladeUp": 0.4,
        "tongueCurl": 0.4,
    }
    return {"jawOpen": with_jaw[name]} if name in with_jaw else {}


def _shape_shot(name: str) -> Shot:
    weights = {name: 1.0, **_companions(name)}
    return Shot(" + ".join(weights), weights, "mouth" if name in TONGUE else "face")


def _two_views(name: str, weights: NDArray[np.float64], framing: str) -> tuple[Shot, Shot]:
    pose = {channel: float(weight) for channel, weight in zip(ALL, weights, strict=True) if weight}
    return Shot(name, pose, framing), Shot("", pose, framing, yaw=35.0)


def _viseme_shots() -> tuple[Shot, ...]:
    mouth = HandMadeMouth()
    phones = {name: [p.lower() for p in sorted(phone_table()) if name in mouth.visemes_of(p)] for name in mouth.visemes}
    rest = _two_views("rest", mouth.rest.shape, "mouth")
    return rest + tuple(
        shot
        for name, viseme in mouth.visemes.items()
        for shot in _two_views(f"{name.replace('_', ' ')}: {' '.join(phones[name])}", viseme.shape, "mouth")
    )


def _expression_shots() -> tuple[Shot, ...]:
    """Each emotion at five moments of ten seconds, the last one from the side."""
    model, rate = hand_made_expression(), FrameRate.of(25)
    shots: list[Shot] = []
    for name in model.names:
        values = model.perform(Score((EmotionSpan(name),)), 10.0, rate, np.random.default_rng(0))
        moments = [values[rate.nearest_frame(seconds)] for seconds in (1.0, 3.0, 5.0, 7.0, 9.0)]
        poses = [{channel: float(weight) for channel, weight in zip(ALL, row, strict=True)} for row in moments]
        shots += [Shot(name if not place else "", pose, "face") for place, pose in enumerate(poses[:-1])]
        shots.append(Shot("", poses[-1], "face", yaw=35.0))
    return tuple(shots)


def _blink_shots() -> tuple[Shot, ...]:
    weights = (0.0, 0.25, 0.5, 0.75, 1.0)
    return tuple(Shot(f"{w:g}", {"eyeBlinkLeft": w, "eyeBlinkRight": w}, "eyes") for w in weights)


def _line_shots() -> tuple[Shot, ...]:
    """Six moments of a spoken line, as `mien say` performs it."""
    animation = mien.say("I never said that.", emotion="angry:0.7")
    phones = [phone for phone in animation.utterance.phones if phone.label in ("AY", "N", "V", "S", "EH", "AE")][:6]
    rows = [(phone.label, animation.channels.values[animation.rate.nearest_frame(phone.middle)]) for phone in phones]
    return tuple(Shot(label, dict(zip(ALL, map(float, row), strict=True)), "face") for label, row in rows)


_TONGUE_VISEMES = (
    "tongue_on_teeth", "tongue_on_ridge", "lateral", "narrow_hiss", "round_hiss", "tongue_back", "curled", "spread",
    "open",
)  # fmt: skip


def _inside_shots() -> tuple[Shot, ...]:
    """The tongue's key shapes and its single shapes: front, from below at the side, and with the near half cut away."""
    mouth = HandMadeMouth()
    phones = {name: [p.lower() for p in sorted(phone_table()) if name in mouth.visemes_of(p)] for name in mouth.visemes}
    poses = {f"{name.replace('_', ' ')}: {' '.join(phones[name])}": _named(mouth.visemes[name].shape)
             for name in _TONGUE_VISEMES if name in mouth.visemes}  # fmt: skip
    poses |= {name: {name: 1.0, **_companions(name)} for name in (*TONGUE, "tongueOut")}
    return tuple(shot for caption, pose in poses.items() for shot in _inside_views(caption, pose))


def _inside_views(caption: str, pose: Mapping[str, float]) -> tuple[Shot, ...]:
    return (
        Shot(caption, pose, "lips"),
        Shot("", pose, "lips", yaw=35.0, pitch=-12.0),
        Shot("", pose, "inside", yaw=72.0, pitch=8.0, cut=True),
    )


def _jaw_shots() -> tuple[Shot, ...]:
    """The opening mouth from three sides."""
    shots: list[Shot] = []
    for weight in (0.3, 0.6, 1.0):
        pose = {"jawOpen": weight}
        shots += [Shot(f"jawOpen {weight:g}", pose, "mouth"), Shot("", pose, "mouth", yaw=40.0)]
        shots.append(Shot("", pose, "mouth", yaw=-20.0, pitch=-15.0))
    return tuple(shots)


def _named(row: NDArray[np.float64]) -> dict[str, float]:
    return {channel: float(weight) for channel, weight in zip(ALL, row, strict=True) if weight}


SENTENCES = ("I never said that.", "We may put my blue book by the bed.", "Oh, it is you again.")
INTENSITIES = (0.0, 0.5, 1.0)


def _pose(animation: Animation, seconds: float) -> dict[str, float]:
    row = animation.channels.values[animation.rate.nearest_frame(seconds)]
    return dict(zip(ALL, map(float, row), strict=True))


def _intensity_shots() -> tuple[Shot, ...]:
    """Every emotion at 0, 0.5 and 1 at one vowel of each of three sentences; the last row: a closed M, B or P."""
    spoken = [mien.say(text) for text in SENTENCES]
    shots = []
    for emotion in (name for name in hand_made_expression().names if name != "neutral"):
        for number, line in enumerate(spoken):
            said = [p for p in line.utterance.phones if p.label != "SIL"]
            vowel = [p for p in said if p.label[0] in "AEIOU"][1 + number % 2].middle
            for intensity in INTENSITIES:
                shown = recolor(line, f"{emotion}:{intensity:g}", way="hand-made")
                caption = f"{emotion} {intensity:g}" if not number or intensity else ""
                shots.append(Shot(caption, _pose(shown, vowel), "face"))
    return tuple(shots)


def _closure_shots() -> tuple[Shot, ...]:
    """Every emotion in full at each bilabial of one sentence: the lips have to be shut."""
    line = mien.say(SENTENCES[1])
    shut = [phone for phone in line.utterance.phones if phone.label in ("P", "B", "M")][:6]
    shots = []
    for emotion in hand_made_expression().names:
        shown = recolor(line, emotion, way="hand-made")
        shots += [Shot(f"{emotion} {phone.label}", _pose(shown, phone.middle), "face") for phone in shut]
    return tuple(shots)


def _recolor_shots() -> tuple[Shot, ...]:
    """One line, neutral and as `mien recolor` makes it in every emotion, at the same six moments."""
    line = mien.say(SENTENCES[0])
    moments = np.linspace(0.12, 0.88, 6) * line.utterance.duration
    shots = []
    for emotion in hand_made_expression().names:
        shown = recolor(line, emotion, way="hand-made")
        shots += [Shot(emotion if not place else "", _pose(shown, t), "face") for place, t in enumerate(moments)]
    return tuple(shots)


def _auto_shots() -> tuple[Shot, ...]:
    """Three voices of EmoDB (in MIEN_DATA): the face shows what they sound like, six moments each."""
    shots = []
    for name in AUTO:
        shown = mien.animate(Path(os.environ["MIEN_DATA"]) / "emodb" / "audio" / f"{name}.flac", emotion="auto")
        found = shown.score.emotions[0].name if shown.score.emotions else "neutral"
        moments = np.linspace(0.1, 0.9, 6) * shown.utterance.duration
        captions = [f"{name}: {found}", *[""] * 5]
        shots += [Shot(text, _pose(shown, t), "face") for text, t in zip(captions, moments, strict=True)]
    return tuple(shots)


def _effort_shots() -> tuple[Shot, ...]:
    """One sentence with little effort, as recorded and with much: the same six moments, open, round and shut."""
    shots = []
    for effort in EFFORTS:
        shown = mien.say(EFFORT_LINE, effort=effort, alive="off", prosody="off")
        said = [p for p in shown.utterance.phones if p.label in EFFORT_PHONES]
        first = {p.label: p for p in reversed(said)}
        shots += [Shot(f"{effort:g}: {label}", _pose(shown, first[label].middle), "face") for label in EFFORT_PHONES]
    return tuple(shots)


def _performer_shots() -> tuple[Shot, ...]:
    """One sentence by each performer that comes with mien, at the same nine phones."""
    shots = []
    for performer in known_performers():
        shown = mien.say(PERFORMERS_LINE, performer=performer, alive="off", prosody="off")
        first = {p.label: p for p in reversed(shown.utterance.phones.intervals)}
        places = [(label, first[label].middle) for label in PERFORMERS_PHONES]
        shots += [Shot(f"{performer}: {label}", _pose(shown, at), "face") for label, at in places]
    return tuple(shots)


def _wander_shots() -> tuple[Shot, ...]:
    """Each emotion without speech, every second of ten."""
    model, rate = hand_made_expression(), FrameRate.of(25)
    shots = []
    for name in model.names:
        values = model.perform(Score((EmotionSpan(name),)), 10.0, rate, np.random.default_rng(3))
        rows = [values[rate.nearest_frame(second)] for second in range(10)]
        shots += [
            Shot(name if not i else "", dict(zip(ALL, map(float, row), strict=True)), "face")
            for i, row in enumerate(rows)
        ]
    return tuple(shots)


def _shape_shots() -> tuple[Shot, ...]:
    return tuple(_shape_shot(name) for name in WEIGHTS)


def _both_views(caption: str, weights: Mapping[str, float]) -> tuple[Shot, Shot]:
    return Shot(caption, weights, "close"), Shot("", weights, "close", yaw=35.0)


def _unit_shots() -> tuple[Shot, ...]:
    """Every action unit at full strength, from the front and at three-quarter."""
    shots = list(_both_views("rest", {}))
    for code, unit in action_units().items():
        shots += _both_views(f"{code} {unit.name}", au_channels(code))
    return tuple(shots)


def _half_unit_shots() -> tuple[Shot, ...]:
    return tuple(
        Shot(f"{code}L {unit.name}", au_channels(code + "L"), "close")
        for code, unit in action_units().items()
        if unit.left
    )


def _basic_shots() -> tuple[Shot, ...]:
    return tuple(shot for name in basic_expressions() for shot in _both_views(name, expression_channels(name)))


SHEETS: dict[str, Sheet] = {
    "units": Sheet(_unit_shots, columns=8, width=200, height=217),
    "units-left": Sheet(_half_unit_shots, columns=8, width=200, height=217),
    "basic-expressions": Sheet(_basic_shots, columns=6, width=250, height=272),
    "neutral": Sheet(lambda: (Shot(""), Shot("", yaw=38.0)), columns=2, width=560, height=640),
    "line": Sheet(_line_shots, columns=6, width=200, height=230),
    "shapes": Sheet(_shape_shots, columns=9, width=190, height=210),
    "visemes": Sheet(_viseme_shots, columns=4, width=250, height=190),
    "tongue": Sheet(_inside_shots, columns=6, width=230, height=175),
    "jaw": Sheet(_jaw_shots, columns=3, width=420, height=320),
    "expressions": Sheet(_expression_shots, columns=5, width=200, height=230),
    "intensities": Sheet(_intensity_shots, columns=9, width=150, height=172),
    "closures": Sheet(_closure_shots, columns=6, width=170, height=195),
    "recolor": Sheet(_recolor_shots, columns=6, width=170, height=195),
    "auto": Sheet(_auto_shots, columns=6, width=200, height=230),
    "effort": Sheet(_effort_shots, columns=6, width=200, height=230),
    "performers": Sheet(_performer_shots, columns=9, width=180, height=207),
    "wander": Sheet(_wander_shots, columns=10, width=140, height=161),
    "blink": Sheet(_blink_shots, columns=5, width=300, height=130),
}


def draw(face: Face, sheet: Sheet) -> Image.Image:
    """All shots of a sheet in one picture."""
    posers = {cut: Poser(_cut(face) if cut else face, ALL) for cut in (False, True)}
    renderers: dict[tuple[str, float, float, bool], Renderer] = {}
    shots = sheet.shots()
    rows = -(-len(shots) // sheet.columns)
    whole = Image.new("RGB", (sheet.columns * sheet.width, rows * sheet.height))
    for place, shot in enumerate(shots):
        view = (shot.framing, shot.yaw, shot.pitch, shot.cut)
        if view not in renderers:
            renderers[view] = _renderer(posers[shot.cut].face, shot, sheet)
        values = np.zeros(len(ALL))
        for name, weight in shot.weights.items():
            if name not in ALL:
                raise unknown_name("channel", name, ALL)
            values[ALL.index(name)] = weight
        picture = Image.fromarray(renderers[view].render(posers[shot.cut].pose(values)))
        ImageDraw.Draw(picture).text((6, 4), shot.caption, fill=(245, 245, 245))
        row, column = divmod(place, sheet.columns)
        whole.paste(picture, (column * sheet.width, row * sheet.height))
    return whole


def _cut(face: Face) -> Face:
    """The face without what lies on the speaker's left, except the tongue."""

    def opened(part: Part) -> Part:
        kept = (part.vertices[part.triangles][:, :, 0] <= 0).all(axis=1)
        return part if part.name == "tongue" else replace(part, triangles=part.triangles[kept])

    kept = [opened(part) for part in face.parts]
    shown = tuple(part for part in kept if len(part.triangles))
    names = {part.name for part in shown}
    return replace(face, parts=shown, eyes=tuple(eye for eye in face.eyes if eye.part in names))


def _renderer(face: Face, shot: Shot, sheet: Sheet) -> Renderer:
    field_mm, middle = FRAMINGS[shot.framing]
    camera = Camera((0.0, middle, 10.0), distance=1100.0, field_mm=field_mm).turned(shot.yaw, shot.pitch)
    return Renderer(face, sheet.width, sheet.height, camera)


def main() -> None:
    """Read the command line and draw."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--out", type=Path, required=True, help="folder for the pictures; made if it is missing")
    parser.add_argument("--face", default="default", help="a face that comes with mien, or a face file")
    parser.add_argument("--only", choices=sorted(SHEETS), help="draw this sheet alone")
    given = parser.parse_args()
    face = load_face(given.face)
    given.out.mkdir(parents=True, exist_ok=True)
    for name in [given.only] if given.only else SHEETS:
        if name == "auto" and "MIEN_DATA" not in os.environ:
            print("auto is left out: MIEN_DATA does not tell where emodb lies")
            continue
        with replace_when_complete(given.out / f"{name}.jpg") as unfinished:
            draw(face, SHEETS[name]).save(unfinished, quality=JPEG_QUALITY, optimize=True)


if __name__ == "__main__":
    main()
