from __future__ import annotations

import zipfile
from dataclasses import replace

import numpy as np
import pytest

from mien.core.errors import InputError
from mien.motion.graph.compact import packed, snapped, steps_for, unpacked
from mien.motion.learning import LearningSettings, learn
from mien.motion.mouth.coarticulation import CoarticulationSettings
from mien.motion.mouth.correction import CorrectionSettings
from mien.motion.mouth.influence import InfluenceSettings
from mien.motion.mouth.speech_motion import SpeechMotionSettings
from mien.motion.performer_file import load_learned, save_learned
from tests.motion.speaking import takes

SMALL = SpeechMotionSettings(
    components=3,
    influence=InfluenceSettings(strands=4, epochs=2, batch=128),
    correction=CorrectionSettings(hidden=(8,), networks=1, epochs=1, batch=128),
)
SETTINGS = LearningSettings(SMALL, CoarticulationSettings(components=3, class_back_off=True))
TIMES = np.arange(0, 1.2, 0.04)


@pytest.fixture(scope="module")
def recorded():
    return takes(8)


@pytest.fixture(scope="module")
def learned(recorded):
    return learn(recorded, SETTINGS)


def test_numbers_snapped_once_are_snapped_for_good():
    values = np.random.default_rng(0).standard_normal((50, 3)) * [1, 10, 100]
    values[4, 1] = np.nan
    for kind in (np.int8, np.int16):
        steps = steps_for(values, kind)
        once = snapped(values, steps, kind)
        assert np.array_equal(unpacked(packed(once, steps, kind), steps), once, equal_nan=True)
        assert np.isnan(once[4, 1])
        assert np.nanmax(np.abs(once - values) / steps) <= 0.51


def test_a_saved_performer_moves_the_same_to_the_bit_whichever_model_moves_it(learned, recorded, tmp_path):
    save_learned(learned, tmp_path / "a.mien")
    loaded = load_learned(tmp_path / "a.mien")
    assert loaded.speech_models == ("coarticulation", "graph", "both")
    assert loaded.speech_model == "both"
    said = recorded[0]
    for name in loaded.speech_models:
        before, after = learned.model(name), loaded.model(name)
        assert np.array_equal(before.synthesise(said.phones, TIMES), after.synthesise(said.phones, TIMES))
    heard = [made.model("both").synthesise_heard(said.phones, TIMES, said.audio) for made in (learned, loaded)]
    assert np.array_equal(*heard)
    save_learned(loaded, tmp_path / "b.mien")
    assert (tmp_path / "a.mien").read_bytes() == (tmp_path / "b.mien").read_bytes()


def test_the_graph_is_read_when_it_is_used_and_mapped(learned, tmp_path, monkeypatch):
    save_learned(learned, tmp_path / "a.mien")
    from mien.motion import performer_file

    read = []
    real = performer_file.mapped_array

    def watched(path, archive, name):
        array = real(path, archive, name)
        read.append((name, isinstance(array, np.memmap)))
        return array

    monkeypatch.setattr(performer_file, "mapped_array", watched)
    loaded = load_learned(tmp_path / "a.mien")
    loaded.model("coarticulation")
    assert read == []
    loaded.model("graph")
    assert {name for name, mapped in read if mapped} == {
        f"graph/{name}" for name in ("motion", "entries", "exits", "features", "residuals")
    }
    before = len(read)
    loaded.model("both")
    assert len(read) == before  # once


def test_performers_without_a_graph_say_what_they_lack(learned, tmp_path):
    bare = replace(learned, recorded=None, speech_model="coarticulation")
    save_learned(bare, tmp_path / "bare.mien")
    loaded = load_learned(tmp_path / "bare.mien")
    assert loaded.speech_models == ("coarticulation",)
    for name in ("graph", "both"):
        with pytest.raises(InputError, match=f"has no speech model '{name}' .it has: coarticulation.; learn one with"):
            loaded.model(name)
    with pytest.raises(InputError, match=r"speech model 'grpah'.*did you mean 'graph'"):
        loaded.model("grpah")


def test_files_of_the_first_version_load(learned, tmp_path):
    save_learned(replace(learned, recorded=None, speech_model="coarticulation"), tmp_path / "new.mien")
    with zipfile.ZipFile(tmp_path / "new.mien") as new, zipfile.ZipFile(tmp_path / "old.mien", "w") as old:
        for entry in new.infolist():
            content = new.read(entry)
            if entry.filename == "performer.json":
                content = content.replace(b'"version": 2', b'"version": 1')
                content = content.replace(b',\n "speech_model": "coarticulation"', b"")
                assert b"speech_model" not in content
            old.writestr(entry, content)
    assert load_learned(tmp_path / "old.mien").model() is not None


def test_a_graph_alone_is_learned_too(recorded, tmp_path):
    made = learn(recorded, replace(SETTINGS, speech_model="graph"))
    save_learned(made, tmp_path / "g.mien")
    loaded = load_learned(tmp_path / "g.mien")
    assert loaded.speech_models == ("coarticulation", "graph")
    assert loaded.model() is loaded.model("graph")
    assert learn(recorded, replace(SETTINGS, speech_model="coarticulation")).recorded is None
    with pytest.raises(InputError, match="speech model"):
        LearningSettings(speech_model="none")


def test_a_file_that_was_changed_or_damaged_meanwhile_is_refused(learned, tmp_path):
    path = tmp_path / "a.mien"
    save_learned(learned, path)
    loaded = load_learned(path)
    save_learned(replace(learned, name="other"), path)
    with pytest.raises(InputError, match="changed after it was loaded"):
        loaded.model("graph")
    loaded = load_learned(path)
    path.unlink()
    with pytest.raises(InputError, match=r"a\.mien: cannot be read"):
        loaded.model("graph")
