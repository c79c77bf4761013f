from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import pytest

from mien.core.errors import InputError
from mien.inspection.shares import ordinary_english, phones_of_text, read_sentences, share_of_pairs
from tests.inspection.performers import known_performer


def test_each_pair_counts_once_by_its_best_evidence():
    # SIL B L UW SIL B L SIL: two pairs in a triphone, L-UW; UW-SIL; then the triphone again and L-SIL
    assert phones_of_text("Blue, bl.")[:5] == ("SIL", "B", "L", "UW", "SIL")
    shares = share_of_pairs(known_performer(), ["blue."])
    assert (shares.sentences, shares.pairs, shares.kinds) == (1, 4, 4)
    assert shares.paper == {"triphone": 0.5, "diphone": 0.25, "class": 0.0, "cosine": 0.25}
    assert shares.mouth == shares.paper
    assert shares.unheard == ((("UW", "SIL"), 1),)


def test_pairs_that_look_alike_count_as_their_classes():
    shares = share_of_pairs(known_performer(), ["plea", "plea"])  # SIL P L IY SIL
    assert shares.pairs == 8
    assert shares.kinds == 4
    assert shares.paper == {"triphone": 0.0, "diphone": 0.0, "class": 0.25, "cosine": 0.75}
    # coverage also knows that a pause leads to a closed mouth
    assert shares.mouth == {"triphone": 0.0, "diphone": 0.0, "class": 0.5, "cosine": 0.5}
    assert shares.unheard == ((("IY", "SIL"), 2), (("L", "IY"), 2))


def test_a_pair_met_too_seldom_is_no_evidence():
    learned = known_performer()
    assert learned.motion.coverage_.diphones_["UW", "AA"] == 1
    assert learned.motion.coverage_.of_pairs(["UW", "AA"]) == ("none",)
    thrice = replace(learned)
    assert share_of_pairs(thrice, ["Ooh, ah."]).mouth["diphone"] == 0


def test_nothing_to_look_at_is_refused():
    with pytest.raises(InputError, match="no sentence"):
        share_of_pairs(known_performer(), [])


def test_sentences_of_files_and_folders(tmp_path: Path):
    (tmp_path / "a").mkdir()
    (tmp_path / "a" / "sa1.txt").write_text("0 54682 She had your dark suit.\n")
    (tmp_path / "b.txt").write_text("# ours\nOne.\n\n  Two of 3.  \n", encoding="utf-8-sig")
    (tmp_path / "c.wrd").write_text("0 1 not this")
    assert read_sentences(tmp_path) == ("She had your dark suit.", "One.", "Two of 3.")
    assert read_sentences(tmp_path / "b.txt") == ("One.", "Two of 3.")


def test_sentences_that_cannot_be_read(tmp_path: Path):
    with pytest.raises(InputError, match="no such text file or folder"):
        read_sentences(tmp_path / "missing.txt")
    with pytest.raises(InputError, match="no sentence found"):
        read_sentences(tmp_path)
    (tmp_path / "odd.txt").write_bytes(b"caf\xe9\n")
    with pytest.raises(InputError, match=r"odd\.txt: cannot be read as UTF-8"):
        read_sentences(tmp_path)


def test_our_own_sentences_can_all_be_spoken():
    shares = share_of_pairs(known_performer(), ordinary_english())
    assert shares.pairs > 1000
    assert sum(shares.paper.values()) == pytest.approx(1)
    assert sum(shares.mouth.values()) == pytest.approx(1)


@pytest.mark.data
def test_timit_sample_has_eighty_transcripts(shared_data: Path):
    sentences = read_sentences(shared_data / "timit-sample")
    spoken = [line for line in sentences if not line[0].isdigit()]
    assert len(spoken) == len(sentences) == 80
    assert "She had your dark suit in greasy wash water all year." in sentences
