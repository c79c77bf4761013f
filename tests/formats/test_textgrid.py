"""TextGrids that Praat reads, and reading those that Praat writes."""

from __future__ import annotations

from itertools import pairwise

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from praatio import textgrid

from mien.core.errors import InputError
from mien.core.timeline import Interval, Tier
from mien.formats.textgrid import read_textgrid, write_textgrid

WORDS = Tier("words", (Interval(0.25, 0.5, "never"), Interval(0.5, 1.1, 'say "never"')))
PHONES = Tier("phones", (Interval(0, 0.25, "SIL"), Interval(0.25, 1.1, "N"), Interval(1.1, 1.5, "SIL")))

LONG = '''File type = "ooTextFile"
Object class = "TextGrid"

xmin = 0 
xmax = 1.5 
tiers? <exists> 
size = 1 
item []: 
    item [1]:
        class = "IntervalTier" 
        name = "words" 
        xmin = 0 
        xmax = 1.5 
        intervals: size = 4 
        intervals [1]:
            xmin = 0 
            xmax = 0.25 
            text = "" 
        intervals [2]:
            xmin = 0.25 
            xmax = 0.5 
            text = "never" 
        intervals [3]:
            xmin = 0.5 
            xmax = 1.1 
            text = "say ""never""" 
        intervals [4]:
            xmin = 1.1 
            xmax = 1.5 
            text = "" 
'''  # noqa: W291

SHORT = '''File type = "ooTextFile"
Object class = "TextGrid"

0
1.5
<exists>
2
"IntervalTier"
"words"
0
1.5
4
0
0.25
""
0.25
0.5
"never"
0.5
1.1
"say ""never"""
1.1
1.5
""
"TextTier"
"clicks"
0
1.5
1
0.75
"click"
'''


def test_long_form_to_the_letter(tmp_path):
    write_textgrid([WORDS], 1.5, tmp_path / "a.TextGrid")
    assert (tmp_path / "a.TextGrid").read_bytes().decode("utf-8") == LONG


def test_short_form_and_points(tmp_path):
    (tmp_path / "a.TextGrid").write_text(SHORT, encoding="utf-8")
    assert read_textgrid(tmp_path / "a.TextGrid") == [WORDS, Tier("clicks", (Interval(0.75, 0.75, "click"),))]


@pytest.mark.parametrize("encoding", ["utf-8", "utf-8-sig", "utf-16"])
@pytest.mark.parametrize("newline", ["\n", "\r\n"])
def test_encodings(tmp_path, encoding, newline):
    text = LONG.replace('"never"', '"nävér"', 1).replace("\n", newline)
    (tmp_path / "a.TextGrid").write_bytes(text.encode(encoding))
    (tier,) = read_textgrid(tmp_path / "a.TextGrid")
    assert tier.intervals[0].label == "nävér"


@settings(max_examples=100, deadline=None)
@given(
    edges=st.lists(st.floats(0, 50).map(lambda t: round(t, 4)), min_size=2, max_size=9, unique=True).map(sorted),
    labels=st.lists(st.text(st.characters(exclude_categories=["C"]), min_size=1), min_size=8, max_size=8),
    gap=st.integers(0, 8),
)
def test_round_trip(tmp_path_factory, edges, labels, gap):
    pairs = zip(edges, edges[1:], labels, strict=False)
    intervals = tuple(Interval(*pair) for number, pair in enumerate(pairs) if number != gap)
    tiers = [Tier("words", intervals), Tier("empty", ())]
    path = tmp_path_factory.mktemp("grid") / "a.TextGrid"
    assert write_textgrid(tiers, 60.0, path) == ()
    assert read_textgrid(path) == tiers


def test_no_gaps_and_praatio_agrees(tmp_path):
    path = tmp_path / "ä.TextGrid"
    write_textgrid([WORDS, PHONES], 1.5, path)
    grid = textgrid.openTextgrid(str(path), includeEmptyIntervals=True, reportingMode="error")
    assert grid.tierNames == ("words", "phones")
    for tier in (WORDS, PHONES):
        entries = grid.getTier(tier.name).entries
        assert (entries[0].start, entries[-1].end) == (0, 1.5)
        assert all(a.end == b.start for a, b in pairwise(entries))
        assert [entry.label for entry in entries if entry.label] == [i.label for i in tier]
    grid.save(str(tmp_path / "short.TextGrid"), format="short_textgrid", includeBlankSpaces=True)
    assert read_textgrid(tmp_path / "short.TextGrid")[1] == PHONES


def test_what_praat_cannot_hold_is_said(tmp_path):
    tier = Tier("phones", (Interval(0.0, 0.5, "AH"), Interval(0.5, 0.5, "T"), Interval(0.5, 0.5 + 5e-10, "D")))
    notes = write_textgrid([tier], 1.0, tmp_path / "a.TextGrid")
    assert [note.message for note in notes] == [
        "phones at 0.500 s ('T') has no length and is not in a.TextGrid",
        "phones at 0.500 s ('D') has no length and is not in a.TextGrid",
    ]
    assert read_textgrid(tmp_path / "a.TextGrid") == [Tier("phones", (Interval(0.0, 0.5, "AH"),))]


def test_edges_within_the_tolerance_leave_no_sliver(tmp_path):
    tier = Tier("phones", (Interval(1e-10, 0.5, "AH"), Interval(0.5 + 1e-10, 1.0 - 1e-10, "T")))
    write_textgrid([tier], 1.0, tmp_path / "a.TextGrid")
    text = (tmp_path / "a.TextGrid").read_text(encoding="utf-8")
    assert "intervals: size = 2" in text
    assert read_textgrid(tmp_path / "a.TextGrid")[0].intervals == (Interval(0, 0.5, "AH"), Interval(0.5, 1.0, "T"))


def test_times_outside_the_sound_stretch_the_grid(tmp_path):
    tier = Tier("words", (Interval(-0.5, 0.5, "a"), Interval(0.9, 1.25, "b")))
    write_textgrid([tier], 1.0, tmp_path / "a.TextGrid")
    assert "xmin = -0.5 \nxmax = 1.25 \n" in (tmp_path / "a.TextGrid").read_text(encoding="utf-8")
    assert read_textgrid(tmp_path / "a.TextGrid") == [tier]


@pytest.mark.parametrize(
    ("content", "message"),
    [
        (LONG[:-60], "cut short"),
        (b"", "not a TextGrid"),
        (b"\xff\x00\xfe", "expected a TextGrid in UTF-8"),
        ("never said", "not a TextGrid"),
        (LONG.replace("IntervalTier", "PitchTier"), "expected IntervalTier"),
        (LONG.replace("xmax = 0.5 ", "xmax = 0.9 "), "before"),
        (LONG.replace("xmax = 0.25", 'xmax = "x"'), "expected a time"),
        (LONG.replace("size = 4", "size = 4.5"), "number of tiers or intervals"),
    ],
)
def test_bad_files(tmp_path, content, message):
    path = tmp_path / "bad.TextGrid"
    path.write_bytes(content if isinstance(content, bytes) else content.encode())
    with pytest.raises(InputError, match=message) as caught:
        read_textgrid(path)
    assert "bad.TextGrid" in str(caught.value)


def test_remarks_bare_fractions_and_rounded_times(tmp_path):
    path = tmp_path / "a.TextGrid"
    path.write_text(
        'File type = "ooTextFile"\nObject class = "TextGrid"\n0 +1.0 ! 3 tiers of "old"\n<exists> 1\n'
        '"IntervalTier" "words" 0 1 2\n.25 ,5003 "a!"\n.5 1 "b"\n'
    )
    (tier,) = read_textgrid(path)
    assert [(i.start, i.end, i.label) for i in tier] == [(0.25, 0.5003, "a!"), (0.5003, 1.0, "b")]


def test_missing_file(tmp_path):
    with pytest.raises(InputError, match="no such file"):
        read_textgrid(tmp_path / "none.TextGrid")
