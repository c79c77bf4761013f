"""Who somebody is: the numbers and names that a face is made from."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field, fields, replace
from functools import cache
from typing import Any

import numpy as np

from mien.core.assets import asset_table, assets_in
from mien.core.errors import InputError, unknown_name
from mien.face.cast.people import drawn_features, feature_names

__all__ = ["AGES", "Person", "blended", "cast_names", "is_blend", "looks", "made_up", "person_called", "person_named"]

AGES = (14, 95)
"""Youngest and oldest face that can be made, years."""
_FOLDER = "faces/cast"
_CHANCE_OF_CUT = {
    "f": ("long", "bob", "tied", "bun", "crop", "curls", "fringe"),
    "m": ("short", "side", "back", "buzz", "crop", "curls", "thinning", "shaved"),
}
_BEARDS = ("", "", "stubble", "full", "goatee", "moustache", "short")
_TIGHT = {
    "african": {"long": "braids", "bob": "afro", "side": "buzz", "back": "buzz", "fringe": "afro", "short": "buzz"}
}

Colour = tuple[float, float, float]


@dataclass(frozen=True)
class Person:
    """What a face is made from; all of it fixed, nothing left to chance but what ``seed`` draws.

    Attributes
    ----------
    name : str
    sex : float
        0 male .. 1 female.
    age : float
        Years, in `AGES`.
    shares : mapping of str to float
        Of MakeHuman's origins african, asian and caucasian; they sum to 1.
    seed : int
        Where each hair and freckle is.
    origin : str
        One of ``looks()["origins"]``; "" between two.
    features : mapping of str to float
        MakeHuman's local targets (`mien.face.cast.people.feature_names`), such as ``nose-width1-incr``: what makes
        this face unlike others of its kind.
    weight, muscle : float
        -1 thin .. 1 heavy.
    tone : float
        Of the skin, 0 fair .. 1 dark.
    freckles, grey : float
        0..1; ``grey`` is how much of the hair has turned.
    hair, beard : str
        Names of cuts (``assets/faces/cuts.toml``); "" is none.
    hair_colour : tuple of tuple of 3 float
        Dark and light strands, sRGB 0..1.
    eyes : tuple of tuple of 3 float
        The iris about the pupil and at its rim, sRGB 0..1.
    brows : float
        How thick, 0..1.3.
    shirt : tuple of 3 float
        sRGB 0..1.
    """

    name: str
    sex: float
    age: float
    shares: Mapping[str, float]
    seed: int
    tone: float
    hair: str
    hair_colour: tuple[Colour, Colour]
    eyes: tuple[Colour, Colour]
    shirt: Colour
    beard: str = ""
    origin: str = ""
    features: Mapping[str, float] = field(default_factory=dict)
    weight: float = 0.0
    muscle: float = 0.0
    freckles: float = 0.0
    grey: float = 0.0
    brows: float = 0.8

    @property
    def summary(self) -> str:
        """In a few words.

        Examples
        --------
        >>> person_named("kofi").summary
        'man, 58, african, hair: buzz, beard: short'
        """
        sex = "woman" if self.sex > 0.5 else "man"
        facts = [
            sex,
            f"{self.age:.0f}",
            self.origin,
            f"hair: {self.hair}",
            f"beard: {self.beard}" if self.beard else "",
        ]
        return ", ".join(fact for fact in facts if fact)

    @property
    def ageing(self) -> float:
        """How far the skin has aged, 0 (30 years and younger) .. 1 (85)."""
        return float(np.clip((self.age - 30) / 55, 0, 1))


@cache
def looks() -> dict[str, Any]:
    """The hand-made tables ``assets/faces/looks.toml`` and ``cuts.toml``."""
    return asset_table("faces/looks.toml") | asset_table("faces/cuts.toml")


def cast_names() -> tuple[str, ...]:
    """Names of the faces in ``assets/faces/cast``, one file each, and in the user's own folder of that name.

    Examples
    --------
    >>> len(cast_names()) >= 16
    True
    """
    return tuple(assets_in(_FOLDER))


def person_named(name: str) -> Person:
    """One of the cast, by its name.

    Raises
    ------
    InputError
        If the name or something in its file is not known.

    Examples
    --------
    >>> person_named("amara").sex
    1.0
    """
    if name not in cast_names():
        raise unknown_name("face", name, cast_names())
    entry = asset_table(f"{_FOLDER}/{name}.toml")
    known = {item.name for item in fields(Person)} - {"name", "shares"} | {"origin", "variety"}
    for key in entry:
        if key not in known:
            raise unknown_name(f"entry in {name}.toml", key, known)
    return made_up(name=name, **entry)


def is_blend(name: str) -> bool:
    """Whether a name asks for something between two of the cast, such as ``amara+mei`` or ``amara+mei:0.3``.

    Examples
    --------
    >>> is_blend("amara+mei:0.3"), is_blend("amara"), is_blend("a+b.glb")
    (True, False, False)
    """
    one, plus, rest = name.partition("+")
    return bool(plus) and one in cast_names() and rest.partition(":")[0] in cast_names()


def person_called(name: str) -> Person:
    """Who a name of the cast, or of a blend of two (`is_blend`), stands for.

    Raises
    ------
    InputError
        If the share of the second is no number from 0 to 1.

    Examples
    --------
    >>> person_called("amara+kofi:0.25").age
    32.5
    """
    one, plus, rest = name.partition("+")
    if not plus:
        return person_named(name)
    other, colon, share = rest.partition(":")
    try:
        number = float(share) if colon else 0.5
    except ValueError:
        number = -1.0
    if not 0 <= number <= 1:
        raise InputError(f"a blend of two faces is NAME+NAME:0..1 (the share of the second), not {name!r}")
    return blended(person_named(one), person_named(other), number)


def made_up(
    sex: str | None = None,
    age: float | None = None,
    origin: str | None = None,
    seed: int = 0,
    name: str = "made-up",
    **own: Any,
) -> Person:
    """A person of whom some things are known; the rest is drawn from the seed, and is the same for the same seed.

    Parameters
    ----------
    sex : {"f", "m"}, optional
    age : float, optional
        Years, in `AGES`.
    origin : str, optional
        One of ``looks()["origins"]``.
    seed : int
        0 or more.
    name : str
    **own
        Any further field of `Person`; ``hair_colour``, ``eyes`` and ``shirt`` by their names in the tables;
        ``features`` go on top of what the seed draws, ``variety`` (1) is how far that goes.

    Raises
    ------
    InputError
        If something is not known or out of range.

    Examples
    --------
    >>> made_up("f", 62, "european", seed=7) == made_up("f", 62, "european", seed=7)
    True
    """
    tables = looks()
    sexes = {"f": 1.0, "female": 1.0, "m": 0.0, "male": 0.0}
    if not isinstance(seed, int) or seed < 0:
        raise InputError(f"a seed is a whole number of 0 or more, not {seed!r}")
    if sex is not None and sex not in sexes:
        raise unknown_name("sex", str(sex), ("f", "m"))
    if age is not None and not (isinstance(age, (int, float)) and AGES[0] <= age <= AGES[1]):
        raise InputError(f"faces are made for ages from {AGES[0]} to {AGES[1]} years, not {age}")
    if origin is not None and origin not in tables["origins"]:
        raise unknown_name("origin", str(origin), tuple(tables["origins"]))
    chance = np.random.default_rng([seed, 1])
    drawn_sex, drawn_age = float(chance.integers(2)), float(chance.uniform(20, 75))
    drawn_origin = str(chance.choice(sorted(tables["origins"])))
    sex_number = drawn_sex if sex is None else sexes[sex]
    origin = origin or drawn_origin
    kind = tables["origins"][origin]
    years = float(drawn_age if age is None else age)
    drawn = _drawn_looks(chance, sex_number, years, kind)
    for key, value in own.items():
        drawn[key] = _named(key, value)
    features = drawn_features(seed, float(drawn.pop("variety", 1.0)))
    for feature, amount in drawn.pop("features", {}).items():
        features[feature] = features.get(feature, 0.0) + amount
    return _checked(
        Person(name, sex_number, years, dict(kind["shares"]), seed, **drawn, origin=origin, features=features)
    )


def _drawn_looks(chance: np.random.Generator, sex: float, age: float, kind: Mapping[str, Any]) -> dict[str, Any]:
    tables, letter = looks(), "f" if sex >= 0.5 else "m"
    tone = float(chance.uniform(*kind["tone"]))
    cut = str(chance.choice(_CHANCE_OF_CUT[letter]))
    if max(kind["shares"], key=kind["shares"].__getitem__) == "african" and kind["shares"]["african"] > 0.5:
        cut = _TIGHT["african"].get(cut, cut)
    if cut in ("thinning", "shaved") and age < 35:
        cut = "short" if cut == "thinning" else "buzz"
    beard = str(chance.choice(_BEARDS)) if letter == "m" and age >= 20 else ""
    grey = float(np.clip((age - 42 + chance.normal(0, 7)) / 30, 0, 1)) ** 1.3
    return {
        "tone": tone,
        "hair": cut,
        "beard": beard,
        "hair_colour": _named("hair_colour", str(chance.choice(kind["hair"]))),
        "eyes": _named("eyes", str(chance.choice(kind["eyes"]))),
        "shirt": _named("shirt", str(chance.choice(sorted(tables["shirts"])))),
        "grey": grey,
        "freckles": float(np.clip(chance.normal(0.1, 0.3), 0, 1)) * (tone < 0.35),
        "brows": float(np.clip(chance.normal(0.72 if letter == "f" else 0.95, 0.12), 0.4, 1.25)),
        "weight": float(np.clip(chance.normal(0.0, 0.25), -0.6, 0.6)),
    }


def _named(key: str, value: Any) -> Any:
    """A colour by its name; anything else as it is."""
    table = {"hair_colour": "hair_colours", "eyes": "eye_colours", "shirt": "shirts"}.get(key)
    if table is None or not isinstance(value, str):
        return value
    known = looks()[table]
    if value not in known:
        raise unknown_name({"eyes": "eye colour", "hair_colour": "hair colour"}.get(key, "shirt"), value, tuple(known))
    found = known[value]
    return tuple(found) if isinstance(found[0], float) else tuple(tuple(colour) for colour in found)


def _checked(person: Person) -> Person:
    cuts = looks()["cuts"]
    if person.hair not in cuts:
        raise unknown_name("cut of hair", person.hair, tuple(cuts))
    beards = looks()["beards"]
    if person.beard and person.beard not in beards:
        raise unknown_name("beard", person.beard, tuple(beards))
    for name in person.features:
        if name not in feature_names():
            raise unknown_name("feature", name, feature_names())
    for key, low, high in (("tone", 0, 1), ("grey", 0, 1), ("freckles", 0, 1), ("brows", 0, 1.3), ("weight", -1, 1),
                           ("muscle", -1, 1)):  # fmt: skip
        value = getattr(person, key)
        if not isinstance(value, (int, float)) or not low <= value <= high:
            raise InputError(f"{key} of a face lies between {low} and {high}, not {value}")
    return person


def blended(one: Person, other: Person, share: float) -> Person:
    """A person between two: ``share`` 0 is the first, 1 the second. Hair and beard are those of the nearer one."""
    near = one if share < 0.5 else other
    mixed: dict[str, Any] = {}
    for entry in fields(Person):
        a, b = getattr(one, entry.name), getattr(other, entry.name)
        if entry.name in ("hair_colour", "eyes"):
            mixed[entry.name] = tuple(_between(x, y, share) for x, y in zip(a, b, strict=True))
        elif entry.name == "shirt":
            mixed[entry.name] = _between(a, b, share)
        elif isinstance(a, float) or isinstance(b, float):
            mixed[entry.name] = a + share * (b - a)
        elif entry.name in ("shares", "features"):
            keys = sorted({*a, *b})
            mixed[entry.name] = {k: (1 - share) * a.get(k, 0.0) + share * b.get(k, 0.0) for k in keys}
    return replace(near, origin=one.origin if one.origin == other.origin else "", **mixed)


def _between(one: Colour, other: Colour, share: float) -> Colour:
    red, green, blue = (a + share * (b - a) for a, b in zip(one, other, strict=True))
    return red, green, blue
