from __future__ import annotations

from collections import Counter
from dataclasses import replace

import numpy as np
import pytest

from mien.inspection.shares import share_of_pairs
from mien.inspection.summary import heard_phones, summary
from mien.motion.performers import load_learned_performer
from tests.inspection.performers import known_performer, small_performer
from tests.motion.speaking import takes


def test_heard_phones_are_those_of_the_takes():
    said = Counter(phone.label for take in takes(30) for phone in take.phones)
    found = heard_phones(small_performer().motion.coverage_)
    assert found == {phone: said[phone] for phone in found}
    assert len(found) == 39
    assert found["OY"] == found["ZH"] == 0


def told(learned) -> str:
    return summary(learned, share_of_pairs(learned, ["blue.", "plea"]))


def test_summary_says_what_was_learned():
    text = told(small_performer())
    assert "performer           small\nlicence             CC0 1.0\n" in text
    assert (
        "learned in          12 markers of the mouth\nlayout              mediapipe-218\nlearned from        30 takes\n"
        in text
    )
    assert "phones              37 of 39 heard\n" in text
    assert "never heard         OY (class round_open), ZH (class round_hiss)\n" in text
    assert "correction_share 0.5, hold_closures yes" in text
    assert "hidden 16, networks 1" in text
    cost = small_performer().fitting_cost
    for number, row in enumerate(["0", "1e-05", "5e-05", "0.0001"]):
        line = next(line for line in text.splitlines() if line.split()[:1] == [row] and len(line.split()) == 7)
        assert [float(value) for value in line.split()[1:]] == cost[number].round().tolist()
    assert max(len(line) for line in text.splitlines()) <= 110


def test_summary_counts():
    text = told(known_performer())
    assert "diphones            4 heard, 3 of them 3 times or more\n" in text
    assert "triphones           1 heard, 1 of them 3 times or more\n" in text
    assert "curves fitted       2 diphones, 1 triphones, 1 class pairs (from 12 time-weight pairs up)" in text
    assert "2 sentences, 8 phone pairs (8 different) rest on\n" in text
    assert "  paper's curves           25.0 %     12.5 %     12.5 %     50.0 %\n" in text
    assert "  heard in learning        25.0 %     12.5 %     25.0 %     37.5 %\n" in text


def test_share_of_variance():
    learned = small_performer()
    space = learned.motion.space_
    line = next(line for line in told(learned).splitlines() if line.startswith("  performing mouth  3 dimensions"))
    each = [float(value) for value in line.rpartition("each, %: ")[2].rstrip(")").split()]
    assert sum(each) == pytest.approx(100 * space.share_, abs=0.2)
    assert np.allclose(np.divide(each, sum(each)), space.variances_ / space.variances_.sum(), atol=0.01)


def test_edits_and_a_missing_licence_are_told():
    learned = small_performer()
    edited = learned.motion.with_key_shape("B", learned.motion.key_shapes("M"))
    text = told(replace(learned, motion=edited, about={}))
    assert "key shapes changed  B\n" in text
    assert "licence             not stated in the file\n" in text


def test_the_default_performer_says_whose_it_is():
    text = told(load_learned_performer("default"))
    assert "licence             CC BY 4.0\n" in text
    assert "phones              33 of 39 heard\n" in text
    for phone in ("UH", "ER", "OY", "SH", "ZH", "NG"):
        assert f"{phone} (class " in text
