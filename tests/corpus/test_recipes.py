from __future__ import annotations

from pathlib import Path

import pytest

from mien.core.errors import InputError
from mien.corpus.readers import READERS
from mien.corpus.recipes import Recipe, known_recipes, load_recipe


@pytest.mark.parametrize("name", known_recipes())
def test_recipes_that_ship_can_be_read_and_name_a_reader(name: str) -> None:
    recipe = load_recipe(name)
    assert recipe.name == name
    assert recipe.reader in {reader.name for reader in READERS}


def test_the_grid_recipe_carries_licence_and_citation() -> None:
    recipe = load_recipe("grid")
    assert recipe.licence == "CC BY 4.0"
    assert "Cooke" in recipe.citation
    assert (recipe.method, recipe.reference, recipe.filter_jitter, recipe.mend) == ("similarity", "first", False, False)


def test_a_recipe_of_ones_own(tmp_path: Path) -> None:
    path = tmp_path / "emo.toml"
    path.write_text(
        'name = "emo"\nabout = "a"\nreader = "tracks"\nfps = 120\n'
        'pattern = "(?P<speaker>..)(?P<sentence>...)(?P<emotion>.).*"\n[emotions]\nW = "angry"\n'
    )
    recipe = load_recipe(str(path))
    assert recipe.facts("03a01Wa") == {"speaker": "03", "sentence": "a01", "emotion": "angry"}
    with pytest.raises(InputError, match=r"x: does not fit the name pattern"):
        recipe.facts("x")
    assert recipe.with_changes(fps=None, emotion="sad").digest() != recipe.digest()


@pytest.mark.parametrize(
    ("line", "message"),
    [
        ('metod = "rigid"', "unknown key in recipe .* did you mean 'method'"),
        ('method = "ridgid"', "unknown normalisation .* did you mean 'rigid'"),
        ("fps = -1.0", "frames per second are above 0"),
        ('mend = "no"', "mend is a bool, got 'no'"),
        ('pattern = "("', "not a valid regular expression"),
        ('pattern = "a.c"', "has no named group"),
        ('pattern = "(?P<mood>.)"', "unknown group in the name pattern 'mood'"),
        ("= 3", "cannot be read as a recipe"),
    ],
)
def test_mistakes_in_a_recipe_are_named(tmp_path: Path, line: str, message: str) -> None:
    path = tmp_path / "own.toml"
    path.write_text(f'name = "own"\nabout = "a"\nreader = "tracks"\n{line}\n')
    with pytest.raises(InputError, match=message):
        load_recipe(str(path))


def test_codes_without_an_entry_stand_for_themselves() -> None:
    assert Recipe("a", "", "video", emotions={"W": "angry"}).emotion_of("happy") == "happy"
