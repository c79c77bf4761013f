"""What the names of morph targets mean: conventions in tables, and how names are taken apart.

The tables are ``assets/rigs/conventions/*.toml`` (the first of them says how they are written) and
``assets/rigs/names.toml``; a table of the user's own is `OwnNames`.
"""

from __future__ import annotations

import re
import tomllib
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from functools import cache
from pathlib import Path
from typing import Any

from mien.core.assets import asset_table, assets_in
from mien.core.border import guarded
from mien.core.channels import WEIGHTS
from mien.core.errors import InputError, unknown_name
from mien.core.facs import au_channels, is_unit
from mien.core.limits import is_whole
from mien.core.plain_text import read_plain_text

__all__ = [
    "Convention",
    "Match",
    "OwnNames",
    "conventions",
    "name_tables",
    "own_names",
    "recognised",
    "spelling",
    "words",
]

Recipe = Mapping[str, float]
_TOKEN = re.compile(r"[A-Z]+(?![a-z])|[A-Z]?[a-z]+|\d+|[^\W\d_A-Za-z]+")
_SIDES = {"l": "left", "lt": "left", "left": "left", "r": "right", "rt": "right", "right": "right"}
_LEAST_TAIL = 7  # letters of a name that is known without its first words
KINDS = ("shapes", "visemes", "spare", "emotions")
"""In the order in which they are trusted: what finer kinds do, coarser ones leave."""


@dataclass(frozen=True)
class Match:
    """What one target's name means.

    Attributes
    ----------
    convention : str
        Title of the table; "your own names" for the user's.
    kind : str
        One of `KINDS`; "own" for the user's.
    recipe : mapping of str to float
        Weight of the target = sum of weight x channel, held in 0..1; empty: left still on purpose.
    exact : bool
        Whether the target is a channel by its own name.
    """

    convention: str
    kind: str
    recipe: Recipe
    exact: bool = False


@dataclass(frozen=True)
class Convention:
    """One table: targets by their spelling (see `spelling`)."""

    title: str
    needs: int
    targets: Mapping[str, Match] = field(repr=False)


@dataclass(frozen=True)
class OwnNames:
    """A table of the user's own; see ``docs/faces.md``.

    Attributes
    ----------
    targets : mapping of str to recipe
        By the target's exact name.
    nodes : mapping of str to str
        Names of the nodes for ``head``, ``eyeLeft`` and ``eyeRight``.
    eyes : mapping of str to float
        Degrees for ``Up``, ``Down``, ``In`` and ``Out`` at weight 1.
    faces : str
        ``"+z"`` or ``"-z"``: where the face looks in the file's axes; "" leaves it to be found.
    """

    targets: Mapping[str, Recipe] = field(default_factory=dict)
    nodes: Mapping[str, str] = field(default_factory=dict)
    eyes: Mapping[str, float] = field(default_factory=dict)
    faces: str = ""


def words(name: str) -> list[str]:
    """The words of a name, in lower case, sides in full, numbers without leading zeros.

    Examples
    --------
    >>> words("AU01_innerBrowRaiser_L"), words("mouthFunnelUL")
    (['au', '1', 'inner', 'brow', 'raiser', 'left'], ['mouth', 'funnel', 'ul'])
    """
    found = [token.lower() for token in _TOKEN.findall(name)]
    return [str(int(word)) if is_whole(word) else _SIDES.get(word, word) for word in found]


def spelling(name: str) -> str:
    """A name as it is compared: its words run together, the side at the end if there is one.

    Examples
    --------
    >>> spelling("Left_eyeBlink"), spelling("eye-blink.L"), spelling("Eye_L_Look_L")
    ('eyeblinkleft', 'eyeblinkleft', 'eyeleftlookleft')
    """
    return _joined(words(name))


def _joined(parts: Sequence[str]) -> str:
    sides = [word for word in parts if word in ("left", "right")]
    if len(sides) == 1:
        return "".join(word for word in parts if word not in ("left", "right")) + sides[0]
    return "".join(parts)


@cache
def name_tables() -> dict[str, Any]:
    """``assets/rigs/names.toml``."""
    return asset_table("rigs/names.toml")


@cache
def conventions() -> tuple[Convention, ...]:
    """All tables of ``assets/rigs/conventions``, ARKit's first.

    Examples
    --------
    >>> [table.title for table in conventions()][:2]
    ['ARKit', 'FACS action units']
    """
    tables = assets_in("rigs/conventions").values()
    paths = sorted(tables, key=lambda path: (path.stem != "arkit", path.stem != "facs", path.stem))
    return tuple(_convention(path) for path in paths)


def _convention(path: Path) -> Convention:
    content = tomllib.loads(path.read_text(encoding="utf-8"))
    title, kind = content["title"], content["kind"]
    found: dict[str, Match] = {}
    for section, section_kind in (("targets", kind), ("spare", "spare")):
        for name, recipe in content.get(section, {}).items():
            for variant, weights in _expanded(name, recipe, path):
                found.setdefault(spelling(variant), Match(title, section_kind, weights))
    if path.stem == "arkit":
        own = {spelling(channel): Match(title, kind, {channel: 1.0}, exact=True) for channel in WEIGHTS}
        found = {**found, **{key: match for key, match in own.items() if key not in found}}
    return Convention(title, content["needs"], found)


def _expanded(name: str, recipe: Recipe, path: Path) -> Iterator[tuple[str, Recipe]]:
    """The names that a table's entry stands for: ``*`` for the sides, ``?`` for none as well."""
    variants = {"Left": "_L_", "Right": "_R_"} if "*" in name or "?" in name else {"": ""}
    for side, letter in variants.items():
        yield re.sub(r"[*?]", letter, name), _sided(recipe, side, path)
    if "?" in name:
        halves: dict[str, float] = {}
        for side in ("Left", "Right"):
            for channel, weight in _sided(recipe, side, path).items():
                shared = channel in recipe
                halves[channel] = weight if shared else halves.get(channel, 0.0) + weight / 2
        yield name.replace("?", ""), halves


def _sided(recipe: Recipe, side: str, path: Path) -> Recipe:
    found = {channel.replace("*", side): float(weight) for channel, weight in recipe.items()}
    for channel in found:
        if channel not in WEIGHTS:
            raise unknown_name(f"channel in {path.name}", channel, WEIGHTS)
    return found


@guarded("a table of names")
def own_names(path: str | Path) -> OwnNames:
    """Read a table of the user's own.

    Raises
    ------
    InputError
        If it cannot be read, or names a channel, unit, node or side that there is not.
    """
    path = Path(path)
    text, _ = read_plain_text(path, "a table of names")
    try:
        content = tomllib.loads(text)
    except ValueError as problem:
        raise InputError(f"{path} is not a table of names in TOML: {problem}") from problem
    allowed = {"targets", "nodes", "eyes", "faces"}
    for name in content:
        if name not in allowed:
            raise unknown_name(f"section in {path}", name, allowed)
    for name in ("targets", "nodes", "eyes"):
        if not isinstance(content.get(name, {}), dict):
            raise InputError(f"{path}: expected a section [{name}]")
    targets = {str(name): _own_recipe(path, name, given) for name, given in content.get("targets", {}).items()}
    for part in content.get("nodes", {}):
        if part not in name_tables()["nodes"]:
            raise unknown_name(f"node in {path}", part, name_tables()["nodes"])
    for way, degrees in content.get("eyes", {}).items():
        if way not in name_tables()["eyes"] or not isinstance(degrees, (int, float)) or not 0 <= degrees <= 90:
            raise InputError(f"{path}: [eyes] has Up, Down, In and Out in degrees from 0 to 90, not {way} = {degrees}")
    if content.get("faces", "") not in ("", "+z", "-z"):
        raise InputError(f"{path}: faces is '+z' or '-z', not {content['faces']!r}")
    nodes = {part: str(name) for part, name in content.get("nodes", {}).items()}
    return OwnNames(targets, nodes, dict(content.get("eyes", {})), content.get("faces", ""))


def _own_recipe(path: Path, name: str, given: object) -> Recipe:
    if given == "":
        return {}
    recipe = {given: 1.0} if isinstance(given, str) else given
    if not isinstance(recipe, dict):
        raise InputError(f"{path}: {name!r} is a channel, a table of channels and weights, or '', not {given!r}")
    found: dict[str, float] = {}
    for channel, weight in recipe.items():
        if not isinstance(weight, (int, float)) or isinstance(weight, bool) or not -10 <= weight <= 10:
            raise InputError(f"{path}: {name!r}: the weight of {channel} is a number from -10 to 10, not {weight!r}")
        if channel in WEIGHTS:
            found[channel] = float(weight)
        elif is_unit(channel):  # shown where its main channel is
            main = max(au_channels(channel).items(), key=lambda entry: entry[1])[1]
            parts = [part for part, share in au_channels(channel).items() if share >= main]
            found |= {part: float(weight) / len(parts) for part in parts}
        else:
            raise unknown_name(f"channel for {name!r} in {path}", channel, WEIGHTS)
    return found


def recognised(names: Sequence[str]) -> list[Match | None]:
    """What the names of one mesh's targets mean, as one whole: short names count only among enough of their kind.

    Examples
    --------
    >>> [match and match.convention for match in recognised(["browDown_L", "AU12", "nonsense", "A"])]
    ['ARKit', 'FACS action units', None, None]
    """
    ways = _ways(names)
    found: list[list[tuple[int, int, Match]]] = [[] for _ in names]
    for order, table in enumerate(conventions()):
        hits = [_first(table, way) for way in ways]
        count = len({id(hit[1]) for hit in hits if hit})
        if count < table.needs:
            continue
        for place, hit in enumerate(hits):
            if hit:
                found[place].append((hit[0], order - 100 * count, hit[1]))
    return [min(hits, key=lambda hit: hit[:2])[2] if hits else None for hits in found]


def _first(table: Convention, way: Sequence[str]) -> tuple[int, Match] | None:
    """The first of the spellings of a name that the table knows, and its place among them."""
    for place, spelt in enumerate(way):
        if spelt in table.targets:
            return place, table.targets[spelt]
    return None


def _ways(names: Sequence[str]) -> list[list[str]]:
    """All spellings under which each name may be known, best first."""
    split = [words(name) for name in names]
    before, after = _shared(split), _shared([parts[::-1] for parts in split])
    tables = name_tables()
    prefixes, suffixes, anatomy = (set(tables[key]) for key in ("prefixes", "suffixes", "anatomy"))
    result = []
    for name, parts in zip(names, split, strict=True):
        starts = [parts]
        segments = re.split(r"\.|\||:|__", name)
        rest = words(" ".join(segments[:-1]))
        if len(segments) > 1 and not anatomy & set(rest):
            starts.append(words(segments[-1]))
        if before or after:
            starts.append(parts[before : len(parts) - after])
        ways = [_joined(form) for start in starts for form in _stripped(start, prefixes, suffixes)]
        for cut in range(1, len(parts) - 1):
            tail = parts[cut:]
            enough = len("".join(tail)) >= _LEAST_TAIL and len([w for w in tail if w not in ("left", "right")]) > 1
            if enough and not anatomy & set(parts[:cut]):
                ways.append(_joined(tail))
        result.append(list(dict.fromkeys(way for way in ways if way)))
    return result


def _stripped(parts: Sequence[str], prefixes: set[str], suffixes: set[str]) -> Iterator[list[str]]:
    """A name's words, and what is left of them without leading and trailing words that say nothing."""
    start, end = 0, len(parts)
    yield list(parts)
    while start < end - 1 and (parts[start] in prefixes or parts[start].isdecimal() or _numbered(parts, start)):
        start += 1
        yield list(parts[start:end])
    while end > start + 1 and (parts[end - 1] in suffixes or parts[end - 1].isdecimal()):
        end -= 1
        yield list(parts[start:end])


def _numbered(parts: Sequence[str], start: int) -> bool:
    """A letter before a number, as in ``A25_Jaw_Open``."""
    return len(parts[start]) == 1 and start + 2 < len(parts) and parts[start + 1].isdecimal()


def _shared(split: Sequence[Sequence[str]]) -> int:
    """How many first words all names share, leaving each one word at least."""
    if len(split) < 3:
        return 0
    count = 0
    while all(len(parts) > count + 1 and parts[count] == split[0][count] for parts in split):
        count += 1
    return count
