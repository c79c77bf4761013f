"""What is said, left out and refused before anything is learned."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from mien.core.errors import InputError
from mien.core.tracks import MarkerTrack
from mien.corpus.take import Take
from mien.motion.expression.expression_motion import Twins
from mien.motion.learning_judgement import faces_apart, judge, variance_ratio
from tests.motion.expressive_takes import take


def moved(one: Take, name: str, offset: float) -> Take:
    """The same take on a face whose jaw is wider by so many millimetres on each side."""
    positions = one.markers.positions.copy()
    positions[:, :, 0] += offset * np.sign(positions[:, :, 0])
    return replace(one, name=name, markers=MarkerTrack(one.markers.names, positions, one.markers.rate))


def said(takes: list[Take], felt: list[Take] | None = None, **options: str) -> str:
    return "\n".join(f"{note.kind}: {note.message}" for note in judge(takes, felt or [], **options).notes)


def test_minutes_phones_and_pairs_are_said_with_numbers() -> None:
    text = said([take(1, "neutral"), take(2, "neutral")])
    assert "warning: 0.1 minutes of speech in 2 takes" in text
    assert "warning: phones: 7 of 39, none of AH" in text
    assert "note: phone pairs: " in text


def test_several_speakers_are_refused_unless_asked_for() -> None:
    takes = [take(1, "neutral"), replace(take(2, "neutral"), speaker="bob")]
    with pytest.raises(InputError, match=r"2 speakers: bob 1 takes, made-up 1 takes; .*--speakers mixed"):
        judge(takes)
    assert "one mouth is learned from 2 speakers" in said(takes, speakers="mixed")
    assert [kept.speaker for kept in judge(takes, speakers="bob").takes] == ["bob"]
    with pytest.raises(InputError, match="unknown speaker 'eve'"):
        judge(takes, speakers="eve")


def test_several_people_without_names_are_known_by_their_faces() -> None:
    one = take(1, "neutral")
    others = [moved(one, "other", 9.0), moved(one, "third", -9.0)]
    assert faces_apart([one, take(2, "neutral"), *others]) == [["s1-neutral", "s2-neutral"], ["other"], ["third"]]
    with pytest.raises(InputError, match=r"3 faces that are not one person's: s1-neutral"):
        judge([one, *others])
    many = [replace(one, name=f"take{i}") for i in range(12)]
    assert "1 takes show a face unlike that of the others: another person, or badly tracked? other" in said(
        [*many, others[0]]
    )


def test_takes_whose_face_was_lost_stay_out() -> None:
    lost = replace(take(2, "neutral"), source={"lost": "60"})
    judgement = judge([take(1, "neutral"), lost])
    assert [kept.name for kept in judgement.takes] == ["s1-neutral"]
    assert any("left out: take 's2-neutral': the face was lost in" in note.message for note in judgement.notes)
    with pytest.raises(InputError, match="in all 1 of them the face was lost"):
        judge([lost])


def test_expressive_takes_without_a_twin_are_named() -> None:
    judgement = judge([take(1, "neutral")], [take(1, "happy"), take(2, "happy"), take(3, "surprised")])
    assert [kept.name for kept in judgement.twins] == ["s1-happy"]
    assert len(judgement.felt) == 3
    line = next(note.message for note in judgement.notes if "without a neutral take" in note.message)
    assert "2 expressive takes (happy 1, surprised 1)" in line
    assert line.endswith("s2-happy, s3-surprised")


def test_twins_that_are_none_are_refused() -> None:
    right = Twins(take(1, "happy"), take(1, "neutral"))
    other = take(2, "neutral")
    wrong = Twins(take(1, "happy"), replace(other, phones=right.neutral.phones, sentence="s1"))
    assert variance_ratio(right) < 0.5
    assert variance_ratio(wrong) > 1.0
    judgement = judge([wrong.neutral], [wrong.expressive])
    assert not judgement.twins
    assert any("they do not match" in note.message for note in judgement.notes)


def test_why_no_map_is_learned_is_said() -> None:
    text = said([take(1, "neutral")], [take(1, "happy")])
    assert "no emotion map is learned: happy and neutral share 1 sentence, 2 are needed" in text
    two = said([take(1, "neutral"), take(2, "neutral")], [take(1, "happy"), take(2, "happy")])
    assert "no emotion map" not in two
