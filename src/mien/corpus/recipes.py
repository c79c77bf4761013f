"""`Recipe`: how the recordings of one kind become takes. Data in ``assets/recipes/NAME.toml`` or a file of your own."""

from __future__ import annotations

import hashlib
import re
import tomllib
from collections.abc import Mapping, Sequence
from dataclasses import asdict, dataclass, field, fields, replace
from pathlib import Path
from typing import Any

from mien.core.assets import asset, assets_in
from mien.core.border import reading
from mien.core.errors import InputError, unknown_name
from mien.core.plain_text import read_plain_text

__all__ = ["FIELDS", "METHODS", "REFERENCES", "UNITS", "Recipe", "known_recipes", "load_recipe"]

METHODS = ("similarity", "rigid", "three-point")
"""How a frame is laid on the reference: all rigid markers, with or without a scale, or the nose and the eye corners."""
REFERENCES = ("first", "closed")
"""Which frame all others are laid on: the first of the set, or a neutral one with the mouth closed."""
UNITS = ("auto", "mm", "cm", "m", "pixels")
FIELDS = ("emotion", "sentence", "speaker", "text")
"""What a table or the pattern of file names may say about a take."""


@dataclass(frozen=True)
class Recipe:
    """How recordings of one kind are read, cleaned and named.

    Attributes
    ----------
    name, about, reader : str
        ``reader`` is one of `mien.corpus.readers.READERS`.
    licence, citation : str
        Go into the corpus, and from there with everything learned from it.
    layout : str
        Name or file of the marker layout; empty: the smallest that has all markers.
    units : str
        One of `UNITS`; ``"auto"`` believes the file, or the size of the face.
    fps : float
        Frames per second, for recordings that do not say it; 0: the file knows.
    mirrored : bool
        The pictures show the speaker as a mirror does.
    method, reference : str
        Of `METHODS` and `REFERENCES`.
    mend, filter_jitter : bool
        Cleaning: mend spikes and swaps; take out the tracker's noise. Gaps are always filled.
    emotion, speaker : str
        For takes of which nothing else is said.
    language : str
        BCP 47 tag of the speech.
    pattern : str
        Regular expression with named groups of `FIELDS`, held against the name of each take.
    emotions : mapping of str to str
        Emotion by the code that the pattern or the table gives.
    rename : mapping of str to str
        Marker of the layout by its name in the file.
    paths, example : str
        Regular expression held against the path of each recording under the source, without suffix; its named groups
        make the take's name (``-`` between), to which ``pattern`` is held. Others are passed over. A path that fits.
    sound, transcript : str
        Where they lie if not beside the recording: a path under the source with groups of ``paths`` in braces.
    texts : mapping of str to str
        What is said, by the code of the sentence.
    spelled : sequence of mapping of str to str
        What is said, where each letter of the sentence's code is a word: words by letter, place by place.
    vertices : mapping of str to int
        Vertex of a mesh by marker; found by the import where it is empty.
    pronunciations : mapping of str to sequence of str
        Words that these speakers say in a way of their own: ARPAbet phones, separated by blanks.
    """

    name: str
    about: str
    reader: str
    licence: str = ""
    citation: str = ""
    layout: str = ""
    units: str = "auto"
    fps: float = 0.0
    mirrored: bool = False
    method: str = "rigid"
    reference: str = "closed"
    mend: bool = True
    filter_jitter: bool = False
    emotion: str = "neutral"
    speaker: str = ""
    language: str = "en-US"
    pattern: str = ""
    paths: str = ""
    example: str = ""
    sound: str = ""
    transcript: str = ""
    texts: Mapping[str, str] = field(default_factory=dict)
    spelled: Sequence[Mapping[str, str]] = ()
    emotions: Mapping[str, str] = field(default_factory=dict)
    rename: Mapping[str, str] = field(default_factory=dict)
    vertices: Mapping[str, int] = field(default_factory=dict)
    pronunciations: Mapping[str, Sequence[str]] = field(default_factory=dict)

    def __post_init__(self) -> None:
        for what, given, known in (
            ("normalisation", self.method, METHODS),
            ("reference", self.reference, REFERENCES),
            ("unit", self.units, UNITS),
        ):
            if given not in known:
                raise unknown_name(f"{what} in recipe {self.name}", given, known)
        if self.fps < 0:
            raise InputError(
                f"recipe {self.name}: frames per second are above 0 (or 0: the file knows), not {self.fps}"
            )
        if self.pattern:
            _check_pattern(self.pattern)
        if self.paths:
            _compiled("pattern of paths", self.paths)

    def with_changes(self, **changes: Any) -> Recipe:
        """The same recipe with some fields replaced; None leaves a field as it is."""
        return replace(self, **{key: value for key, value in changes.items() if value is not None})

    def facts(self, name: str) -> dict[str, str]:
        """What the pattern says about a take of this name; empty without a pattern.

        Raises
        ------
        InputError
            If the name does not fit the pattern.

        Examples
        --------
        >>> recipe = Recipe("mine", "", "video", pattern="(?P<speaker>.+)-(?P<emotion>[HS])", emotions={"H": "happy"})
        >>> recipe.facts("anna-H")
        {'speaker': 'anna', 'emotion': 'happy'}
        """
        if not self.pattern:
            return {}
        match = re.fullmatch(self.pattern, name)
        if match is None:
            raise InputError(f"{name}: does not fit the name pattern {self.pattern!r}; mend the pattern or the name")
        said = {
            key: self.emotion_of(value) if key == "emotion" else value for key, value in match.groupdict("").items()
        }
        if "text" in said:
            said["text"] = said["text"].replace("_", " ")
        text = self.text_of(said.get("sentence", ""))
        return said | {"text": text} if text and not said.get("text") else said

    def text_of(self, sentence: str) -> str:
        """What a sentence's code stands for; empty if the recipe does not say.

        Examples
        --------
        >>> Recipe("mine", "", "video", spelled=({"b": "bin", "l": "lay"}, {"b": "blue"})).text_of("lb")
        'lay blue'
        """
        if sentence in self.texts:
            return self.texts[sentence]
        if len(sentence) != len(self.spelled):
            return ""
        return " ".join(words.get(letter, letter) for letter, words in zip(sentence, self.spelled, strict=True))

    def emotion_of(self, code: str) -> str:
        """The emotion that a code stands for; a code without an entry is the emotion itself."""
        return self.emotions.get(code, code)

    def digest(self) -> str:
        """Twelve hex digits that change with every setting."""
        return hashlib.sha256(repr(sorted(asdict(self).items())).encode()).hexdigest()[:12]


def _compiled(what: str, pattern: str) -> Mapping[str, int]:
    try:
        return re.compile(pattern).groupindex
    except re.error as problem:
        raise InputError(f"the {what} {pattern!r} is not a valid regular expression: {problem}") from problem


def _check_pattern(pattern: str) -> None:
    groups = _compiled("name pattern", pattern)
    if not groups:
        raise InputError(
            f"the name pattern {pattern!r} has no named group; give (?P<emotion>...) or another of {FIELDS}"
        )
    for group in groups:
        if group not in FIELDS:
            raise unknown_name("group in the name pattern", group, FIELDS)


def known_recipes() -> tuple[str, ...]:
    """Names of the recipes that come with mien.

    Examples
    --------
    >>> known_recipes()  # doctest: +NORMALIZE_WHITESPACE
    ('beat', 'biwi', 'c3d', 'cremad', 'grid', 'grid-speakers', 'livelink', 'lombard-grid', 'mead', 'multiface',
     'ravdess', 'savee', 'tcd-timit', 'tracks', 'video', 'vocaset')
    """
    return tuple(assets_in("recipes"))


def load_recipe(name: str) -> Recipe:
    """Read a recipe by its name, or from a ``.toml`` file.

    Raises
    ------
    InputError
        If the name is not known, the file cannot be read, or a key or value in it is not known.

    Examples
    --------
    >>> load_recipe("grid").licence
    'CC BY 4.0'
    """
    if name.endswith(".toml"):
        path = Path(name)
    elif name in known_recipes():
        path = asset(f"recipes/{name}.toml")
    else:
        raise unknown_name("recipe", name, known_recipes())
    with reading(path, "a recipe"):
        return _recipe(path, tomllib.loads(read_plain_text(path, "a recipe")[0]))


def _recipe(path: Path, content: Mapping[str, Any]) -> Recipe:
    known = {f.name: type(f.default) for f in fields(Recipe) if isinstance(f.default, (str, bool, float))}
    for key in content:
        if key not in {f.name for f in fields(Recipe)}:
            raise unknown_name(f"key in recipe {path.name}", key, [f.name for f in fields(Recipe)])
        kind = known.get(key)
        if kind is not None and not isinstance(content[key], (float, int) if kind is float else kind):
            raise InputError(f"{path}: {key} is a {kind.__name__}, got {content[key]!r}")
    missing = {"name", "about", "reader"} - set(content)
    if missing:
        raise InputError(f"{path}: a recipe needs {', '.join(sorted(missing))} too")
    return Recipe(**content)
