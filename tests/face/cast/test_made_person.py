import re
from pathlib import Path

import pytest

from mien.core.assets import asset
from mien.core.errors import InputError
from mien.face.cast.made_person import blended, cast_names, made_up, person_called, person_named


def test_the_cast_has_both_sexes_three_ages_and_many_origins() -> None:
    cast = [person_named(name) for name in cast_names()]
    assert len(cast) >= 16
    for sex in (0.0, 1.0):
        ages = [person.age for person in cast if person.sex == sex]
        assert min(ages) < 30 < 50 < max(ages)
        assert any(35 < age < 60 for age in ages)
    assert len({person.origin for person in cast}) >= 6
    assert len({person.hair for person in cast}) >= 12
    assert {person.beard for person in cast} >= {"", "full", "goatee", "moustache", "stubble"}


def test_no_two_of_the_cast_are_alike() -> None:
    cast = [person_named(name) for name in cast_names()]
    assert len({(p.hair, p.hair_colour, p.beard, p.shirt, round(p.tone, 1)) for p in cast}) == len(cast)


def test_the_same_seed_is_the_same_person_and_another_seed_another() -> None:
    assert made_up(seed=5) == made_up(seed=5)
    assert made_up(seed=5) != made_up(seed=6)


def test_a_blend_lies_between() -> None:
    one, other = person_named("amara"), person_named("walter")
    half = blended(one, other, 0.5)
    assert one.age < half.age < other.age
    assert half.shares == pytest.approx({"african": 0.5, "caucasian": 0.5})
    assert blended(one, other, 0.0).features == pytest.approx({**dict.fromkeys(other.features, 0.0), **one.features})


@pytest.mark.parametrize(
    ("wrong", "said"),
    [
        ({"sex": "x"}, "unknown sex"),
        ({"age": 7}, "14 to 95"),
        ({"origin": "mars"}, "unknown origin"),
        ({"seed": -1}, "whole number"),
        ({"hair": "mullet"}, "unknown cut of hair"),
        ({"eyes": "pink"}, "unknown eye colour"),
        ({"tone": 2.0}, "between 0 and 1"),
        ({"features": {"horns": 1.0}}, "unknown feature"),
        ({"weight": "heavy"}, "weight"),
    ],
)
def test_what_cannot_be_is_refused(wrong: dict[str, object], said: str) -> None:
    with pytest.raises(InputError, match=said):
        made_up(**wrong)  # type: ignore[arg-type]


def test_a_face_of_ones_own_is_one_file(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    (tmp_path / "faces" / "cast").mkdir(parents=True)
    (tmp_path / "faces" / "cast" / "mine.toml").write_text('sex = "f"\nage = 40\n')
    monkeypatch.setenv("MIEN_TABLES", str(tmp_path))
    assert "mine" in cast_names()
    assert person_named("mine").age == 40
    (tmp_path / "faces" / "cast" / "bad.toml").write_text("hare = 1\n")
    with pytest.raises(InputError, match="did you mean 'hair'"):
        person_named("bad")


@pytest.mark.parametrize("name", ["amara+mei:2", "amara+mei:much"])
def test_a_share_that_is_none_is_refused(name: str) -> None:
    with pytest.raises(InputError, match=r"NAME\+NAME:0..1"):
        person_called(name)


def test_a_table_with_something_of_another_kind_is_one_line(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    folder = tmp_path / "faces" / "cast"
    folder.mkdir(parents=True)
    text = asset("faces/cast/amara.toml").read_text(encoding="utf-8")
    (folder / "mine.toml").write_text(re.sub(r"(?m)^hair = .*$", "hair = 3", text), encoding="utf-8")
    monkeypatch.setenv("MIEN_TABLES", str(tmp_path))
    with pytest.raises(InputError, match="unknown cut of hair 3"):
        person_named("mine")
