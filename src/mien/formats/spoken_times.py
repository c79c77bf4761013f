"""Words and phones in time as other tools keep them: ``.json``, ``.csv``, ``.srt``, ``.vtt``, ``.lab``, ``.ctm``.

=========  ===========================================================================================================
``.json``  text, language, duration; words and phones with start and end, seconds
``.csv``   one line for each word and phone: tier, start, end, label
``.srt``   subtitles (SubRip): the text as written, cut at pauses and at `CUE_LETTERS` letters
``.vtt``   the same as WebVTT
``.lab``   phones as HTK and HTS keep them: start and end in units of 100 ns, label
``.ctm``   words as NIST's scoring tools keep them: name, channel, start, duration, word
=========  ===========================================================================================================
"""

from __future__ import annotations

import csv
import io
import json
from collections.abc import Callable, Iterator
from pathlib import Path

from mien.core.errors import Note, unknown_name
from mien.core.files import replace_when_complete
from mien.core.timeline import Interval, Tier
from mien.core.utterance import Utterance
from mien.formats.textgrid import write_textgrid
from mien.text.languages import read_words

__all__ = ["TIME_FORMATS", "write_times"]

CUE_LETTERS = 42
"""Letters in a subtitle, as broadcasters set a line."""
CUE_SECONDS = 6.0
CUE_PAUSE = 0.4
"""Seconds of silence at which a subtitle ends."""


def write_times(utterance: Utterance, path: str | Path) -> tuple[Note, ...]:
    """Write words and phones with their times; the suffix picks the format (`TIME_FORMATS`).

    Parameters
    ----------
    utterance : Utterance
    path : str or Path

    Returns
    -------
    tuple of Note
        What the file could not hold.

    Raises
    ------
    InputError
        If the suffix is not that of a format.
    OutputError
        If the file cannot be written.
    """
    path = Path(path)
    suffix = path.suffix.lower()
    if suffix == ".textgrid":
        return write_textgrid((utterance.words, utterance.spelled_phones), utterance.duration, path)
    if suffix not in _WRITERS:
        raise unknown_name("format of words in time", path.suffix, TIME_FORMATS)
    written = _WRITERS[suffix](utterance, path.stem)
    with replace_when_complete(path) as unfinished:
        unfinished.write_text(written, encoding="utf-8", newline="\n")
    return ()


def _json(utterance: Utterance, _: str) -> str:
    def listed(tier: Tier) -> list[dict[str, object]]:
        return [{"start": round(i.start, 6), "end": round(i.end, 6), "label": i.label} for i in tier]

    about = {"text": utterance.text, "language": utterance.language, "duration": utterance.duration}
    tiers = {"words": listed(utterance.words), "phones": listed(utterance.spelled_phones)}
    return json.dumps(about | tiers, ensure_ascii=False, indent=1) + "\n"


def _csv(utterance: Utterance, _: str) -> str:
    out = io.StringIO()
    rows = csv.writer(out, lineterminator="\n")
    rows.writerow(["tier", "start", "end", "label"])
    for name, tier in (("words", utterance.words), ("phones", utterance.spelled_phones)):
        rows.writerows([name, f"{i.start:.6f}", f"{i.end:.6f}", i.label] for i in tier)
    return out.getvalue()


def _lab(utterance: Utterance, _: str) -> str:
    return "".join(f"{round(i.start * 1e7)} {round(i.end * 1e7)} {i.label}\n" for i in utterance.spelled_phones)


def _ctm(utterance: Utterance, name: str) -> str:
    name = "_".join(name.split()) or "sound"
    return "".join(f"{name} 1 {i.start:.3f} {i.duration:.3f} {i.label}\n" for i in utterance.words)


def _srt(utterance: Utterance, _: str) -> str:
    cues = enumerate(_cues(utterance), start=1)
    return "\n".join(f"{number}\n{_clock(c.start, ',')} --> {_clock(c.end, ',')}\n{c.label}\n" for number, c in cues)


def _vtt(utterance: Utterance, _: str) -> str:
    cues = [f"{_clock(c.start, '.')} --> {_clock(c.end, '.')}\n{_escaped(c.label)}\n" for c in _cues(utterance)]
    return "\n".join(["WEBVTT\n", *cues])


def _escaped(text: str) -> str:
    return text.replace("&", "&amp;").replace("<", "&lt;").replace(">", "&gt;")


def _clock(seconds: float, mark: str) -> str:
    thousandths = round(max(seconds, 0.0) * 1000)
    minutes, rest = divmod(thousandths, 60_000)
    return f"{minutes // 60:02d}:{minutes % 60:02d}:{rest // 1000:02d}{mark}{rest % 1000:03d}"


def _cues(utterance: Utterance) -> Iterator[Interval]:
    """Stretches of speech with the text as it was written."""
    words = utterance.words.intervals
    if not words:
        return
    written = _written(utterance)
    first = 0
    for number, word in enumerate(words):
        following = words[number + 1] if number + 1 < len(words) else None
        if (
            following is None
            or following.start - word.end >= CUE_PAUSE
            or following.end - words[first].start > CUE_SECONDS
            or len(written(first, number + 1)) > CUE_LETTERS
        ):
            yield Interval(words[first].start, word.end, written(first, number))
            first = number + 1


def _written(utterance: Utterance) -> Callable[[int, int], str]:
    """The written text of words ``first`` to ``last``, with the punctuation that follows; else the words themselves."""
    labels = [word.label for word in utterance.words]
    language = None if utterance.language.lower().startswith(("en", "und")) else utterance.language
    spoken = read_words(utterance.text, language) if utterance.text.strip() else None
    if spoken is None or len(spoken.words) != len(labels):
        return lambda first, last: " ".join(labels[first : last + 1])
    ends = [word.end for word in spoken.words]
    starts = [word.start for word in spoken.words[1:]] + [len(spoken.written)]

    def text(first: int, last: int) -> str:
        begin = 0 if first == 0 else spoken.words[first].start
        until = max(ends[last], starts[last])
        return " ".join(spoken.written[begin:until].split())

    return text


_WRITERS: dict[str, Callable[[Utterance, str], str]] = {
    ".json": _json, ".csv": _csv, ".srt": _srt, ".vtt": _vtt, ".lab": _lab, ".ctm": _ctm,
}  # fmt: skip
TIME_FORMATS: tuple[str, ...] = (".TextGrid", *_WRITERS)
