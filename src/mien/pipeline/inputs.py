"""What is said: texts, scripts and recordings as the public calls take them, made into speech with its direction."""

from __future__ import annotations

import os
from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING, cast

from mien.core.audio import Audio
from mien.core.errors import InputError, Note
from mien.core.utterance import Utterance
from mien.formats.sound_files import read_audio
from mien.motion.performer import Performer
from mien.text.commands import CommandLibrary
from mien.text.score import UNDIRECTED, EmotionSpan, Score
from mien.text.script import Script

if TYPE_CHECKING:
    from mien.pipeline.speak import Synthesiser
    from mien.pipeline.spoken import Spoken

__all__ = ["heard", "is_timed", "read_text", "sound_of", "spoken_recording", "spoken_text"]

_DOCUMENTS = (".xml", ".ssml", ".bml")


def spoken_text(
    text: str | Path | Script,
    performer: Performer,
    *,
    voice: str | None = None,
    language: str | Path | None = None,
    seed: int = 0,
    commands: str | Path | Sequence[str | Path] = (),
    score: Score = UNDIRECTED,
    voice_emotion: float = 1.0,
    synthesiser: Synthesiser | None = None,
) -> Spoken:
    """The first half of `say`: a text with a voice and all its direction in time, before anybody performs it.

    Parameters
    ----------
    performer : Performer
        Must have the emotions that the text asks for.
    text, voice, language, seed, commands
        As for `say`.
    score : Score
        What is felt besides what the text says: the voice goes with it.
    voice_emotion : float
        How much it does, 0 to 1.
    synthesiser : Synthesiser, optional
        As for `mien.pipeline.speak.speak`.

    Raises
    ------
    InputError, MissingPartError
        As `say`.
    """
    from mien.pipeline.speak import speak
    from mien.pipeline.translate import translate

    library = _library(commands)
    script = _script(text, library)
    performer.expression.check(Score(tuple(EmotionSpan(asked.name) for asked in script.emotions)))
    said = speak(script, voice, seed, library, language, score, voice_emotion, synthesiser)
    return translate(said, library)


def spoken_recording(
    audio: str | Path | Audio,
    performer: Performer,
    *,
    text: str | Path | Script | None = None,
    language: str | Path | None = None,
    song: bool = False,
    tiers: Sequence[str] = (),
    commands: str | Path | Sequence[str | Path] = (),
    notes: tuple[Note, ...] = (),
) -> Spoken:
    """The first half of `animate`: a recording with its words, phones and direction in time.

    Parameters
    ----------
    performer : Performer
        Must have the emotions that the text asks for.
    audio, text, language, song, tiers, commands
        As for `animate`.
    notes : tuple of Note
        What is known of the sound already.

    Raises
    ------
    InputError
        As `animate`.
    """
    from mien.pipeline.speak import speak_over
    from mien.pipeline.spoken import Spoken
    from mien.pipeline.translate import translate

    library = _library(commands)
    if text is None or is_timed(text):
        return Spoken(heard(audio, cast("str | Path | None", text), language, song, tiers).with_notes(*notes))
    if tiers:
        raise InputError("tiers are those of a TextGrid: give one as the text (--text X.TextGrid)")
    script = _script(text if isinstance(text, Script) else _file_or_text(text), library)
    performer.expression.check(Score(tuple(EmotionSpan(asked.name) for asked in script.emotions)))
    spoken = speak_over(
        script, lambda words, said: heard(audio, words, said, song).with_notes(*notes), library, language
    )
    return translate(spoken, library)


def read_text(text: str | Path) -> str:
    """The text itself, or the content of the file that it names.

    Raises
    ------
    InputError
        If it names a file that is missing or is not UTF-8 text.

    Examples
    --------
    >>> read_text("I never said that.")
    'I never said that.'
    """
    if not isinstance(text, (str, Path)):
        raise InputError(f"expected a text or the path of a text file, got {type(text).__name__}")
    path = Path(text)
    one_word = len(str(text).split()) == 1
    is_name = isinstance(text, Path) or (one_word and (path.suffix.lower() in (".txt", ".lab") or os.sep in str(text)))
    try:
        is_file = path.is_file()
    except OSError:  # a text too long to be a file name
        is_file = False
    if not is_file:
        if is_name and path.is_dir():
            raise InputError(f"{text}: expected a text file, got a folder")
        if is_name:
            raise InputError(f"{text}: no such text file")
        return str(text)
    try:
        return path.read_text(encoding="utf-8-sig")
    except UnicodeDecodeError as problem:
        raise InputError(
            f"{path}: expected UTF-8 text, got other bytes at byte {problem.start}; save it as UTF-8"
        ) from (problem)
    except OSError as problem:
        raise InputError(f"{path}: cannot be read ({problem.strerror})") from problem


def _script(text: str | Path | Script, library: CommandLibrary) -> Script:
    from mien.text.script_reading import read_script, read_script_file

    if isinstance(text, Script):
        return text
    if isinstance(text, Path):
        return read_script_file(text, library)
    if not isinstance(text, str):
        raise InputError(f"expected a text to say, got {type(text).__name__}")
    return read_script(text, library)


def _file_or_text(text: str | Path) -> str | Path:
    """A script file as its path, anything else as `read_text` takes it."""
    if isinstance(text, str) and len(text.split()) == 1 and text.lower().endswith(_DOCUMENTS):
        return Path(text)
    if isinstance(text, Path) and text.suffix.lower() in _DOCUMENTS:
        return text
    return read_text(text)


def _library(commands: str | Path | Sequence[str | Path]) -> CommandLibrary:
    return CommandLibrary.of(*([commands] if isinstance(commands, (str, Path)) else commands))


def sound_of(audio: str | Path | Audio) -> tuple[Audio, tuple[Note, ...]]:
    """Samples, read if they lie in a file, with the notes on reading them.

    Raises
    ------
    InputError
        If the sound cannot be read.
    """
    if isinstance(audio, Audio):
        return audio, ()
    if not isinstance(audio, (str, Path)):
        raise InputError(f"expected a sound or the path of a sound file, got {type(audio).__name__}")
    return read_audio(audio)


def is_timed(text: object) -> bool:
    """Whether what is said is the path of a TextGrid, whose times are taken as they are."""
    return isinstance(text, (str, Path)) and len(str(text)) < 4096 and str(text).strip().lower().endswith(".textgrid")


def heard(
    audio: str | Path | Audio,
    text: str | Path | None,
    language: str | Path | None = None,
    song: bool = False,
    tiers: Sequence[str] = (),
) -> Utterance:
    """Words and phones of a sound, with the notes on reading it."""
    if is_timed(text):
        return _heard_as_given(audio, Path(str(text).strip()), language, song, tiers)
    if tiers:
        raise InputError("tiers are those of a TextGrid: give one as the text (--text X.TextGrid)")
    said = read_text(text) if text is not None else None
    if said is not None and not said.strip():
        raise InputError(
            "expected a text that says what is spoken, got an empty one; leave it out to have it recognised"
        )
    if song and said is None:
        raise InputError("a song needs its lyrics: give them with --text (words are not recognised in songs)")
    audio, notes = sound_of(audio)
    if said is None:
        from mien.speech.recognise import recognise
        from mien.text.languages.language import ENGLISH

        utterance = recognise(audio, language=str(language or ENGLISH))
    elif song:
        from mien.speech.song import align_song
        from mien.text.languages.language import ENGLISH

        utterance = align_song(audio, said, language=language or ENGLISH)
    else:
        from mien.speech.align import align as force_align
        from mien.text.languages.language import ENGLISH

        utterance = force_align(audio, said, language=language or ENGLISH)
    if not song:
        from mien.speech.song import note_on_singing

        notes = (*notes, *note_on_singing(audio))
    return utterance.with_notes(*notes)


def _heard_as_given(
    audio: str | Path | Audio, path: Path, language: str | Path | None, song: bool, tiers: Sequence[str]
) -> Utterance:
    from mien.formats.textgrid import read_textgrid
    from mien.speech.given_times import spoken_as_given

    if song:
        raise InputError(f"{path}: a song takes its lyrics as a text, not as a TextGrid")
    given = read_textgrid(path)
    sound, notes = sound_of(audio)
    try:
        return spoken_as_given(sound, given, names=tiers, language=language).with_notes(*notes)
    except InputError as problem:
        raise InputError(f"{path}: {problem}") from problem
