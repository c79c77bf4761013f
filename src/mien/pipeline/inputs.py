"""What is said: texts, scripts and recordings as the public calls take them, made into speech with its direction.

One rule for all commands: a `Path` is a file; a string is one if it ends like a text file (`TEXT_FILES`) and is a
single word or the name of a file that is there. Everything else is text.
"""

from __future__ import annotations

import os
from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING

from mien.core.audio import Audio
from mien.core.errors import InputError, Note
from mien.core.one_thread import one_thread
from mien.core.plain_text import read_plain_text
from mien.core.utterance import Utterance
from mien.formats.sound_files import read_audio
from mien.motion.performer import Performer
from mien.text.commands import CommandLibrary
from mien.text.score import UNDIRECTED, EmotionSpan, Score
from mien.text.script import Prosody, Script
from mien.text.spoken_text import Spelled
from mien.text.sync_points import Moment

if TYPE_CHECKING:
    from mien.pipeline.speak import Listener, Synthesiser
    from mien.pipeline.spoken import Spoken

__all__ = [
    "TEXT_FILES",
    "aligned",
    "heard",
    "is_timed",
    "read_text",
    "script_of",
    "sound_of",
    "spoken_recording",
    "spoken_text",
    "text_or_file",
]

DOCUMENTS = (".xml", ".ssml", ".bml")
TEXT_FILES = (".txt", ".lab", *DOCUMENTS, ".textgrid")
"""Endings by which a string is taken for the name of a file."""
_LONGEST_NAME = 4096


@one_thread
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
    rate: float | None = None,
    pitch: float | None = None,
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
    rate, pitch : float or None
        Of the whole, as ``<prosody>`` around it: as a multiple, and semitones.
    synthesiser : Synthesiser, optional
        As for `mien.pipeline.speak.speak`.

    Raises
    ------
    InputError, MissingPartError
        As `say`.
    """
    from mien.pipeline.speak import speak
    from mien.pipeline.spoken import translate

    library = _library(commands)
    script = script_of(text, library)
    performer.expression.check(Score(tuple(EmotionSpan(asked.name) for asked in script.emotions)))
    if rate is not None or pitch is not None:
        whole = Prosody(Moment.at("start"), Moment.at("end"), rate, pitch)
        script = replace(script, prosody=(whole, *script.prosody))
    said = speak(script, voice, seed, library, language, score, voice_emotion, synthesiser)
    return translate(said, library)


@one_thread
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
    from mien.pipeline.spoken import Spoken, translate

    library = _library(commands)
    if isinstance(text, Path) and is_timed(text):
        return Spoken(_heard_as_given(audio, text, language, song, tiers).with_notes(*notes))
    _refuse_tiers(tiers)
    if text is None:
        return Spoken(heard(audio, None, language, song).with_notes(*notes))
    script = script_of(text, library)
    performer.expression.check(Score(tuple(EmotionSpan(asked.name) for asked in script.emotions)))
    spoken = translate(speak_over(script, _hearing(audio, song, notes), library, language), library)
    spoken.utterance.audio.rest()
    return spoken


@one_thread
def aligned(
    audio: str | Path | Audio,
    text: str | Path | Script,
    language: str | Path | None = None,
    song: bool = False,
    tiers: Sequence[str] = (),
) -> Utterance:
    """Words and phones of a recording by its text, as `mien.align` gives them.

    Raises
    ------
    InputError
        As `mien.align`.
    """
    from mien.pipeline.speak import speak_over

    if isinstance(text, Path) and is_timed(text):
        return _heard_as_given(audio, text, language, song, tiers)
    _refuse_tiers(tiers)
    return speak_over(script_of(text), _hearing(audio, song, ()), None, language).utterance


def _refuse_tiers(tiers: Sequence[str]) -> None:
    if tiers:
        raise InputError("tiers are those of a TextGrid: give one as the text (--text X.TextGrid)")


def _hearing(audio: str | Path | Audio, song: bool, notes: tuple[Note, ...]) -> Listener:
    """What `speak_over` aligns with."""

    def listen(text: str, language: str | Path | None, spellings: Sequence[Spelled]) -> Utterance:
        return heard(audio, text, language, song, spellings).with_notes(*notes)

    return listen


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
    said: str | None,
    language: str | Path | None = None,
    song: bool = False,
    spellings: Sequence[Spelled] = (),
) -> Utterance:
    """Words and phones of a sound, with the notes on reading it."""
    if said is not None and not said.strip():
        raise InputError(
            "expected a text that says what is spoken, got an empty one (mien animate without --text recognises phones)"
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
        if spellings:
            utterance = utterance.with_notes(Note("note", "<phoneme> is not followed in a song"))
    else:
        from mien.speech.align import align as force_align
        from mien.text.languages.language import ENGLISH

        utterance = force_align(audio, said, language=language or ENGLISH, spellings=spellings)
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


def text_or_file(text: str | Path) -> str | Path:
    """What is given as it is, or as a `Path` if it names a file.

    Examples
    --------
    >>> text_or_file("I never said that."), text_or_file("nowhere/line.txt")
    ('I never said that.', PosixPath('nowhere/line.txt'))
    """
    if not isinstance(text, (str, Path)):
        raise InputError(f"expected a text or the path of a text file, got {type(text).__name__}")
    if isinstance(text, Path) or len(text) > _LONGEST_NAME or "\n" in text:
        return text
    name = text.strip()
    one_word, named = len(name.split()) == 1, name.lower().endswith(TEXT_FILES)
    if one_word and named:
        return Path(name)
    if (named or (one_word and os.sep in name)) and os.path.isfile(name):  # noqa: PTH113 - Path cannot hold any text
        return Path(name)
    return text


def read_text(text: str | Path) -> str:
    """The text itself, or the content of the file that it names.

    Raises
    ------
    InputError
        If it names a file that is missing or holds no text.

    Examples
    --------
    >>> read_text("I never said that.")
    'I never said that.'
    """
    found = text_or_file(text)
    return found if isinstance(found, str) else _content(found)[0]


def script_of(text: str | Path | Script, library: CommandLibrary | None = None) -> Script:
    """A script, from a text with tags or the file that a `Path` names.

    Raises
    ------
    InputError
        If it cannot be read or its tags are not understood.
    """
    from mien.text.script_reading import read_script, read_script_file

    if isinstance(text, Script):
        return text
    if isinstance(text, str):
        return _with_note(read_script(text, library), text)
    if not isinstance(text, Path):
        raise InputError(f"expected a text to say, got {type(text).__name__}")
    if text.suffix.lower() in DOCUMENTS:
        return read_script_file(text, library)
    if text.suffix.lower() == ".textgrid":
        raise InputError(f"{text}: a TextGrid goes with its recording: mien animate SOUND --text {text.name}")
    content, notes = _content(text)
    script = read_script(content, library, str(text))
    return replace(script, notes=(*notes, *script.notes))


def _content(path: Path) -> tuple[str, tuple[Note, ...]]:
    if not path.exists():
        raise InputError(f"{path}: no such text file")
    if path.is_dir():
        raise InputError(f"{path}: expected a text file, got a folder")
    return read_plain_text(path)


def _with_note(script: Script, text: str) -> Script:
    """Say so where a word that is spoken is also the name of a file here."""
    name = text.strip()
    if len(name.split()) != 1 or len(name) > 255 or not os.path.isfile(name):  # noqa: PTH113
        return script
    note = Note("note", f"{name!r} is spoken as a word; to read the file of that name, write .{os.sep}{name}")
    return replace(script, notes=(*script.notes, note))
