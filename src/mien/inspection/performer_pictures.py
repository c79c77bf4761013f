"""All pictures of what a performer has learned."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from functools import cache, partial

from PIL import Image

from mien.core.utterance import PAUSE
from mien.face.model import Face
from mien.inspection.coverage_picture import draw_coverage
from mien.inspection.curve_pictures import draw_curves, draw_fitting_cost, most_heard, read_sequence
from mien.inspection.expression_picture import draw_expression_space
from mien.inspection.influence_picture import draw_influence, evenly_spoken
from mien.inspection.key_shape_sheets import KeyShapes
from mien.motion.expression.hand_made_performance import hand_made_space
from mien.motion.mouth.coverage import heard_phones
from mien.motion.performer_file import LearnedSpeech

__all__ = ["DEFAULT_WORD", "Picture", "pictures_of"]

DEFAULT_WORD = "maybe"
Picture = tuple[str, Callable[[], Image.Image]]
"""Name of the file, and what draws it."""


def pictures_of(
    learned: LearnedSpeech, phones: Sequence[str] = (), word: str = DEFAULT_WORD, face: Face | None = None
) -> list[Picture]:
    """Pictures of what was learned, not yet drawn: the last three take seconds.

    Parameters
    ----------
    learned : LearnedSpeech
    phones : sequence of str
        Diphones and triphones whose curves are wanted, such as ``"P AA"``; none: those heard most.
    word : str
        Word or sentence whose influence curves are wanted.
    face : Face or None
        Where key shapes are shown; None takes the default face.

    Raises
    ------
    InputError
        If there are no curves for what is asked, or the word cannot be spoken.
    """
    evenly_spoken(word)
    pictures: list[Picture] = []
    for name, length in (("diphones", 2), ("triphones", 3)):
        wanted = [sequence for sequence in map(read_sequence, phones) if len(sequence) == length]
        sequences = wanted if phones else most_heard(learned.coarticulation, length)
        if sequences:
            drawn = draw_curves(learned.coarticulation, sequences)
            pictures.append((f"{name}.png", drawn.copy))
    pictures += [
        ("fitting-cost.png", partial(draw_fitting_cost, learned)),
        ("coverage.png", partial(draw_coverage, learned.motion.coverage_)),
        ("influence.png", partial(draw_influence, learned.motion, word)),
        (("expressions.png" if learned.expressions else "expressions-hand-made.png"), partial(_draw_space, learned)),
    ]
    return pictures + _sheets(learned, face)


def _draw_space(learned: LearnedSpeech) -> Image.Image:
    """The performer's own expression space, or else the hand-made one that it uses."""
    return draw_expression_space(learned.expressions.space if learned.expressions else hand_made_space())


def _sheets(learned: LearnedSpeech, face: Face | None) -> list[Picture]:
    @cache
    def shapes() -> KeyShapes:
        return KeyShapes(learned, face)

    def of_speaker() -> Image.Image:
        heard = {**heard_phones(learned.motion.coverage_), PAUSE: 1}
        found = shapes().of_speaker().items()
        return shapes().sheet({n if heard[n.partition(".")[0]] else f"{n} (never heard)": v for n, v in found})

    return [
        ("key-shapes-speaker.png", of_speaker),
        ("key-shapes-face.png", lambda: shapes().sheet(shapes().of_face())),
        ("key-shapes-classes.png", lambda: shapes().sheet(shapes().of_classes(), columns=5)),
    ]
