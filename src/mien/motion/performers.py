"""The performers that come with mien, and performers in files of your own."""

from __future__ import annotations

from collections.abc import Callable, Iterable
from pathlib import Path

from mien.core.assets import asset, assets_in
from mien.core.errors import InputError, unknown_name
from mien.core.plug_ins import plug_ins
from mien.motion.alive.idle import HandMadeIdle
from mien.motion.performer import Performer
from mien.motion.performer_file import LearnedSpeech, load_learned

__all__ = [
    "FORMER_NAME",
    "HAND_MADE",
    "brought_performers",
    "known_performers",
    "load_learned_performer",
    "load_performer",
    "start_named",
]

HAND_MADE = "hand-made"
"""Name of the performer that was made by hand and needs no file."""
FORMER_NAME = "authored"
"""What it was called in version 0.1; still understood."""


def known_performers() -> tuple[str, ...]:
    """Names of the performers that come with mien, and of those that other packages bring.

    Examples
    --------
    >>> known_performers()
    ('hand-made', 'default', 'mandarin')
    """
    return (HAND_MADE, *assets_in("performers", ".mien"), *brought_performers())


def brought_performers() -> dict[str, tuple[str, Callable[[], Performer]]]:
    """Performers of other packages, whose mouth models are their own."""
    return plug_ins("mien.performers", callable, "a function that returns a Performer")


def load_learned_performer(name: str | Path) -> LearnedSpeech:
    """What was learned of a performer, by name or from a ``.mien`` file.

    Raises
    ------
    InputError
        If the name is not known, or the file is missing or damaged.

    Examples
    --------
    >>> load_learned_performer("default").motion.mouth_.kind
    'channels'
    """
    learned = list(assets_in("performers", ".mien"))
    if isinstance(name, Path) or str(name).lower().endswith(".mien"):
        return load_learned(name)
    if name not in learned:
        raise _unknown("learned performer", str(name), learned)
    return load_learned(asset(f"performers/{name}.mien"))


def _unknown(what: str, name: str, known: Iterable[str]) -> InputError:
    """A name that nobody has, or a file that is of something else."""
    if len(name) < 256 and Path(name).is_file():  # longer ones are no file's, and is_file would raise
        return InputError(
            f"{name} is not a performer: expected a file that ends in .mien, or one of {', '.join(known)}"
        )
    return unknown_name(what, name, known)


NOTHING = "nothing"
"""Name of the start that is none."""


def start_named(name: str) -> LearnedSpeech | None:
    """The performer that learning starts from, by name or file; None for ``nothing``.

    Raises
    ------
    InputError
        As `load_learned_performer`.

    Examples
    --------
    >>> start_named("nothing") is None
    True
    """
    return None if name == NOTHING else load_learned_performer(name)


def load_performer(name: str | Path = "default", speech_model: str | None = None) -> Performer:
    """A performer ready to speak, by name or from a ``.mien`` file.

    A learned performer brings its own mouth, and its own expressions where they were recorded; the other expressions
    and the signs of life are hand-made.

    Parameters
    ----------
    name : str or Path
    speech_model : str or None
        ``coarticulation``, ``graph`` or ``both``, as far as the performer has learned it; None takes its own.

    Raises
    ------
    InputError
        If the name is not known, the file is missing or damaged, or the performer lacks the speech model.

    Examples
    --------
    >>> load_performer("hand-made").name
    'hand-made'
    """
    if name in (HAND_MADE, FORMER_NAME):
        if speech_model is not None:
            raise InputError(
                f"the hand-made performer has no speech model {speech_model!r}: it was learned from nobody"
            )
        return Performer.hand_made()
    if not (isinstance(name, Path) or str(name).lower().endswith(".mien")) and name not in known_performers():
        raise _unknown("performer", str(name), known_performers())
    if str(name) in brought_performers():
        return _of_a_package(str(name), speech_model)
    from mien.motion.expression.recorded_expression import expression_of
    from mien.motion.mouth.learned_mouth import LearnedMouth

    learned = load_learned_performer(name)
    mouth = LearnedMouth(learned, speech_model=speech_model)
    expression = expression_of(learned.expressions)
    return Performer(learned.name, mouth, expression, HandMadeIdle(), emotion_maps=learned.emotion_maps)


def _of_a_package(name: str, speech_model: str | None) -> Performer:
    package, made = brought_performers()[name]
    if speech_model is not None:
        raise InputError(f"the performer {name} of the package {package} has one speech model, its own")
    performer = made()
    if not isinstance(performer, Performer):
        raise InputError(f"the package {package} made no Performer for {name}, but {type(performer).__name__}")
    return performer
