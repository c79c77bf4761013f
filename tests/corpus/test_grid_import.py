"""The recipe for GRID on the recordings themselves: alignment included, laid as the scoring wants it."""

from __future__ import annotations

import json
import shutil
from pathlib import Path

import numpy as np
import pytest
from numpy.typing import NDArray

from mien.capture.layouts import load_layout
from mien.capture.tracker import tracker_python
from mien.core.errors import MissingPartError
from mien.corpus.importing import import_corpus

NAMES = ("bbaf2n", "bbaz5s", "prii9a")  # the first of the set, one with a Z, one with gaps
RIGID = (33, 133, 362, 263, 168, 6, 197, 195, 5, 10, 151, 9, 8, 1, 4, 98, 327)


@pytest.fixture(scope="module")
def few(shared_data: Path, tmp_path_factory: pytest.TempPathFactory) -> Path:
    source, folder = shared_data / "grid-s1", tmp_path_factory.mktemp("grid")
    with np.load(source / "markers.npz") as takes:
        np.savez(folder / "markers.npz", **{name: takes[name] for name in NAMES})
    shutil.copy(source / "meta.json", folder)
    for part, suffix in (("audio", ".flac"), ("words", ".align")):
        (folder / part).mkdir()
        for name in NAMES:
            shutil.copy(source / part / f"{name}{suffix}", folder / part)
    return folder


def scored(few: Path, name: str) -> NDArray[np.float64]:
    """By the words of the scoring: y up, similarity on 17 landmarks to the first frame, 90 mm between 33 and 263."""
    ids = json.loads((few / "meta.json").read_text())["landmark_ids"]
    with np.load(few / "markers.npz") as takes:
        raw = {n: np.where(takes[n] == -32768, np.nan, takes[n] / 64) * [1, -1, -1] for n in (NAMES[0], name)}
    first = raw[NAMES[0]][0]
    first = first * 90.0 / np.linalg.norm(first[ids.index(33)] - first[ids.index(263)])
    rigid = [ids.index(number) for number in RIGID]
    laid = np.full_like(raw[name], np.nan)
    for frame, points in enumerate(raw[name]):
        if np.isfinite(points).all():
            own, target = points[rigid], first[rigid]
            left, right = own - own.mean(axis=0), target - target.mean(axis=0)
            u, sizes, vt = np.linalg.svd(right.T @ left)
            flip = np.array([1, 1, np.linalg.det(u @ vt)])
            factor = (sizes * flip).sum() / (left**2).sum()
            laid[frame] = factor * (points - own.mean(axis=0)) @ ((u * flip) @ vt).T + target.mean(axis=0)
    layout = load_layout("mediapipe-218")
    return laid[:, [ids.index(number) for number in sorted(layout.landmarks)]]


@pytest.mark.data
def test_takes_lie_as_the_scoring_wants_them(few: Path, tmp_path: Path) -> None:
    report = import_corpus(few, tmp_path / "out", workers=0)
    assert report.imported == NAMES
    layout = load_layout("mediapipe-218")
    order = [layout.index([layout.landmarks[number]])[0] for number in sorted(layout.landmarks)]
    for name in NAMES:
        mine = report.corpus.take(name).markers.positions[:, order]
        theirs = scored(few, name)
        # distances between markers do not depend on how the whole set is turned
        apart = np.linalg.norm(mine[:, ::9, None] - mine[:, None, ::9], axis=3)
        expected = np.linalg.norm(theirs[:, ::9, None] - theirs[:, None, ::9], axis=3)
        recorded = np.isfinite(theirs).all(axis=(1, 2))
        assert np.abs(apart - expected)[recorded].max() < 1e-3
        assert np.isfinite(mine).all()
    gaps = report.corpus.entries["prii9a"]["source"]
    assert int(gaps["filled"]) == 11 * 218
    assert "lost face" in gaps["notes"]


@pytest.mark.data
def test_words_are_aligned_near_those_supplied(few: Path, tmp_path: Path) -> None:
    corpus = import_corpus(few, tmp_path / "out", workers=0).corpus
    late = []
    for name in NAMES:
        lines = [line.split() for line in (few / "words" / f"{name}.align").read_text().splitlines()]
        supplied = [(int(start) / 25_000, word) for start, _, word in lines if word not in ("sil", "sp")]
        words = corpus.take(name).words.intervals
        assert [interval.label for interval in words] == [word for _, word in supplied]
        late += [interval.start - start for interval, (start, _) in zip(words, supplied, strict=True)]
    assert abs(float(np.median(late))) < 0.04
    phones = [interval.label for interval in corpus.take("bbaz5s").phones]
    assert "EH" in phones[phones.index("Z") : phones.index("Z") + 2]  # a British "zed"


@pytest.mark.data
def test_raw_video_agrees_with_the_tracked_arrays(few: Path, shared_data: Path, tmp_path: Path) -> None:
    try:
        tracker_python()
    except MissingPartError as missing:
        pytest.skip(str(missing))
    (tmp_path / "in").mkdir()
    for part in ("video/bbaz5s.mpg", "words/bbaz5s.align"):
        shutil.copy(shared_data / "grid-s1" / part, tmp_path / "in")
    video = import_corpus(tmp_path / "in", tmp_path / "video", workers=0).corpus.take("bbaz5s").markers
    tracked = import_corpus(few, tmp_path / "out", workers=0).corpus.take("bbaz5s").markers
    lips = [[track.positions[:, track.names.index(m)] for m in ("2.2", "2.3")] for track in (video, tracked)]
    openings = [np.linalg.norm(upper - lower, axis=1) for upper, lower in lips]
    assert np.corrcoef(*openings)[0, 1] > 0.97
