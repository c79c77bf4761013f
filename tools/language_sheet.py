"""Draw the vowels and corner consonants of a language on one sheet, held and between vowels.

::

    python tools/language_sheet.py fi docs/pictures/finnish.jpg

Each vowel is seen short and long in its middle, from the front; each corner consonant (lips, teeth, tongue) between two
open vowels, short and long. No figure here is measured: it is for looking.
"""

from __future__ import annotations

import argparse
from pathlib import Path

import numpy as np
from PIL import Image

from mien.core.audio import Audio
from mien.core.timeline import FrameRate, Interval, Tier
from mien.core.utterance import Utterance
from mien.face.library import load_face
from mien.face.model import Face
from mien.face.posing import Poser
from mien.face.render.camera import Camera
from mien.face.render.renderer import Renderer
from mien.formats.contact_sheet import contact_sheet
from mien.motion.performers import load_performer
from mien.pipeline.perform import perform
from mien.text.languages import Language, find_language, in_english_phones
from mien.text.score import Score

SHEETS = {
    "fi": ("ɑ e i o u y æ ø", "p m ʋ f t s r l k h j ŋ"),
    "de": ("a ɛ eː i oː uː yː øː œ ʏ", "p pf f v ts s ʃ ç x r"),
    "es": ("a e i o u", "p b β f θ s tʃ ɲ r x"),
}
RATE = FrameRate.of(100)
SIZE = (230, 200)


def spoken(labels: list[tuple[str, float]], language: Language) -> Utterance:
    """A silent utterance of phones with their seconds, rests at both ends."""
    rows, now = [], 0.0
    for label, seconds in [("SIL", 0.4), *labels, ("SIL", 0.4)]:
        rows.append(Interval(now, now + seconds, label))
        now += seconds
    native = Tier("phones", tuple(rows))
    phones, shapes = in_english_phones(native, language)
    sound = Audio.silence(now, 16_000)
    return Utterance("", sound, Tier("words", ()), phones, language.tag, "aligned", native=native, shapes=shapes)


def pictures(language: Language, face: Face) -> tuple[list[np.ndarray], list[str]]:
    """Every phone of the sheet, and its caption."""
    performer = load_performer("default")
    camera = Camera((0.0, -60.0, 10.0), distance=1100.0, field_mm=105.0)
    renderer = Renderer(face, *SIZE, camera)
    vowels, consonants = (group.split() for group in SHEETS[language.tag])
    asked = [
        ([("t", 0.07), (v, s), ("t", 0.07)], 1, 0.5, f"{v}{'ː' * (s > 0.2)}") for v in vowels for s in (0.09, 0.28)
    ]
    for consonant in consonants:
        for seconds, mark in ((0.07, ""), (0.20, "ː")):
            asked.append(([("a", 0.12), (consonant, seconds), ("a", 0.12)], 1, 0.5, f"a{consonant}{mark}a"))
    images, captions = [], []
    poser = None
    for labels, place, share, caption in asked:
        line = perform(spoken(labels, language), Score(), performer, RATE)
        poser = poser or Poser(face, line.channels.names)
        assert line.utterance.native is not None
        phone = line.utterance.native.intervals[place + 1]
        frame = RATE.nearest_frame(phone.start + share * phone.duration)
        images.append(renderer.render(poser.pose(line.channels.values[frame])))
        captions.append(caption)
    return images, captions


def main() -> None:
    """Read the command line and draw."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("language", choices=sorted(SHEETS))
    parser.add_argument("out", type=Path)
    options = parser.parse_args()
    language = find_language(options.language)
    assert language is not None
    images, captions = pictures(language, load_face("default"))
    Image.fromarray(contact_sheet(images, captions, 8)).save(options.out, quality=86)


if __name__ == "__main__":
    main()
