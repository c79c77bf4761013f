import json
import zipfile
from copy import copy
from dataclasses import replace
from io import BytesIO

import numpy as np
import pytest

from mien.core.errors import InputError
from mien.core.timeline import Interval, Tier
from mien.core.tracks import MarkerTrack
from mien.corpus.recordings import Corpus, identity_of
from mien.motion.learning import LearningSettings, learn, learn_corpus
from mien.motion.mouth import influence, speech_motion
from mien.motion.mouth.articulation import articulation_table
from mien.motion.mouth.coarticulation import CoarticulationSettings
from mien.motion.mouth.correction import CorrectionSettings
from mien.motion.mouth.influence import InfluenceSettings
from mien.motion.mouth.lip_closure import LEAST_APART, LipClosure
from mien.motion.mouth.mouth_space import ChannelSpace, MarkerSpace
from mien.motion.mouth.speech_motion import SpeechMotion, SpeechMotionSettings
from mien.motion.performer_file import load_learned, save_learned
from tests.motion.speaking import NAMES, take, takes, tier

SMALL = SpeechMotionSettings(
    components=3,
    influence=InfluenceSettings(strands=4, epochs=6, batch=128),
    correction=CorrectionSettings(hidden=(24,), networks=2, epochs=4, batch=128),
)
SETTINGS = LearningSettings(SMALL, CoarticulationSettings(components=3, class_back_off=True))
EVERY_PHONE = tier(["SIL", *[phone for phone in articulation_table().parts if phone != "SIL"], "SIL"], 0.11)
TIMES = np.arange(0, 4.5, 0.04)


@pytest.fixture(scope="module")
def recorded():
    return takes(40)


@pytest.fixture(scope="module")
def model(recorded):
    return SpeechMotion(SMALL).fit(recorded)


def opening(positions):
    return np.linalg.norm(positions[:, 0] - positions[:, 1], axis=1)


def test_new_sentences_move_as_their_speaker_would(model):
    new = takes(4, seed=50, noise=0.0)
    for said in new:
        at = said.markers.rate.times(len(said.markers))
        made = model.synthesise(said.phones, at)
        assert np.corrcoef(opening(made), opening(said.markers.positions))[0, 1] > 0.9
        assert np.sqrt(((made - said.markers.positions) ** 2).sum(axis=2).mean()) < 1.2


def test_a_block_of_a_long_line_looks_at_its_own_phones_alone(model, monkeypatch):
    phones, times, seen = tier(["SIL", *["B", "AA", "S", "IY"] * 200, "SIL"], 0.1), np.arange(0, 80, 0.02), []
    cut = influence.parts_of
    monkeypatch.setattr(influence, "parts_of", lambda told: seen.append(len(told)) or cut(told))
    made = model.synthesise(phones, times)
    assert sum(seen) < 12 * len(phones)  # three instants a frame, in blocks of twenty seconds with what lies about them
    monkeypatch.setattr(speech_motion, "BLOCK", 10**9)
    assert np.allclose(made, model.synthesise(phones, times), atol=1e-9)


def test_the_explicit_part_is_what_is_learned_without_a_network(model, recorded):
    alone = SpeechMotion(replace(SMALL, correction_share=0.0)).fit(recorded)
    phones = tier(["SIL", "B", "AA", "M", "SIL"], 0.2)
    times = np.arange(0, 1, 0.04)
    assert (model.explicit(recorded).synthesise(phones, times) == alone.synthesise(phones, times)).all()


def test_every_phone_has_a_mouth_also_those_never_recorded(model):
    made = model.synthesise(EVERY_PHONE, TIMES)
    assert made.shape == (len(TIMES), 12, 3)
    assert np.isfinite(made).all()
    assert opening(made).max() < 16  # nothing flies off: the speaker's widest aim is 12 mm
    like = model.key_shapes("SH"), model.key_shapes("ZH")  # ZH was never said; it is made like SH
    assert np.abs(like[0] - like[1]).max() < 1.5
    assert model.key_shapes("OY").shape == (2, 12, 3)


def test_lips_shut_at_each_bilabial_and_only_as_far_as_recorded(model):
    phones = tier(["SIL", "AA", "B", "AA", "M", "IY", "P", "AY", "SIL"], 0.09)
    for fps in (25, 30, 60):
        at = np.arange(0, 0.81, 1 / fps)
        made = opening(model.synthesise(phones, at))
        for phone in phones:
            near = (at >= phone.start - 0.05) & (at < phone.end + 0.05)
            if phone.label in "BMP":
                assert made[near].min() < model.closure_.apart_["bilabial"] + 0.05
    free = SpeechMotion(SMALL)
    free.__dict__.update(model.__dict__)
    free.settings = replace(SMALL, hold_closures=False)
    at = np.arange(0, 0.81, 0.04)
    held, loose = model.synthesise(phones, at), free.synthesise(phones, at)
    assert (opening(held) <= opening(loose) + 1e-9).all()
    assert np.array_equal(held[opening(loose) == opening(held)], loose[opening(loose) == opening(held)])


def test_inner_lips_never_pass_through_each_other(model):
    random = np.random.default_rng(0)
    for said in takes(10, seed=77):
        wild = said.markers.positions + random.standard_normal(said.markers.positions.shape)
        rows = model.closure_.hold(model.mouth_.rows_from(wild), said.phones, said.markers.rate.times(len(wild)))
        held = model.mouth_.motion_of(rows)
        for upper, lower in model.mouth_.facing:
            assert (held[:, upper, 1] >= held[:, lower, 1] - 1e-9).all()
    assert model.mouth_.facing == ((8, 9), (0, 1))


def test_lips_that_no_phone_shuts_stay_apart():
    space = ChannelSpace.of(("jawOpen", "mouthLowerDownLeft"))
    closure = LipClosure(space)
    closure.apart_, closure.delay_ = {"bilabial": 0.0}, {}
    ajar = space.rows_from(np.array([[0.02, 0.0]]))
    closure.closing_ = ajar[0] / (space.opening_of(ajar)[0] - space.gap[0])
    phones = tier(["W", "R", "B", "W"], 0.2, start=0.2)
    times = np.arange(0, phones.intervals[-1].end, 0.02)
    held = space.opening_of(closure.hold(np.zeros((len(times), 2)), phones, times))
    assert held[(times > 0.26) & (times < 0.54)].min() > LEAST_APART - 0.05
    assert held[(times > 0.62) & (times < 0.78)].max() < 0.5
    assert held[times < 0.19].max() < 0.01


def test_the_mouth_rests_in_long_pauses():
    random = np.random.default_rng(0)
    made = []
    for number in range(20):
        spoken = tier(random.choice(["AA", "S", "IY", "UW", "B", "K"], 10).tolist(), 0.1, start=0.6)
        pauses = Interval(0.0, 0.6, "SIL"), Interval(1.6, 2.2, "SIL")
        made.append(take(f"t{number}", Tier("phones", (pauses[0], *spoken, pauses[1]))))
    resting = SpeechMotion(SMALL).fit(made)
    phones = Tier("phones", (Interval(0.0, 3.0, "SIL"), Interval(3.0, 3.2, "AA"), Interval(3.2, 6.0, "SIL")))
    shut = opening(resting.synthesise(phones, np.array([1.0, 2.0, 3.1, 5.0])))
    assert shut[[0, 1, 3]].max() < 1.5  # the speaker's is 0.3 mm
    assert shut[2] > 8


def test_lips_are_found_by_name():
    assert MarkerSpace("mediapipe-218", NAMES).opening == (0, 1)
    assert MarkerSpace("mpeg4-32", ("8.3", "8.4")).opening is None


def test_markers_without_lips_are_learned_and_nothing_is_held(recorded):
    kept = [4, 5, 10, 11]
    few = [
        replace(t, markers=MarkerTrack([NAMES[k] for k in kept], t.markers.positions[:, kept], t.markers.rate))
        for t in recorded[:8]
    ]
    made = SpeechMotion(SMALL).fit(few)
    assert made.closure_.apart_ == {}
    assert made.synthesise(EVERY_PHONE, TIMES).shape == (len(TIMES), 4, 3)


def test_only_the_mouth_is_learned(recorded):
    more = [
        replace(
            t,
            markers=MarkerTrack(
                (*NAMES, "11.1"), np.pad(t.markers.positions, ((0, 0), (0, 1), (0, 0))), t.markers.rate
            ),
        )
        for t in recorded[:6]
    ]
    assert SpeechMotion(SMALL).fit(more).mouth_.names == NAMES


def test_an_edited_key_shape_shows_in_full(model):
    phones = tier(["SIL", "S", "AA", "S", "SIL"], 0.3)
    wanted = model.key_shapes("AA")
    step = model.space_.decode(np.array([[4.0, 0.0, 0.0], [0.0, 0.0, 0.0]]))
    wanted = wanted + (step[0] - step[1]).reshape(12, 3)
    edited = model.with_key_shape("AA", wanted)
    assert np.allclose(edited.key_shapes("AA"), wanted, atol=1e-6)
    assert model.edits_ == {}
    at = np.array([0.72])  # deep inside AA, where its influence is nearly one
    moved = (edited.synthesise(phones, at) - model.synthesise(phones, at)).reshape(-1)
    assert moved @ (step[0] - step[1]) > 0.75 * ((step[0] - step[1]) ** 2).sum()
    still = np.array([0.05])
    assert np.abs(edited.synthesise(phones, still) - model.synthesise(phones, still)).max() < 0.2
    with pytest.raises(InputError, match=r"key shapes of AY have shape \(2, 12, 3\)"):
        model.with_key_shape("AY", wanted)


def test_without_correction_the_curves_stand_alone(recorded):
    alone = SpeechMotion(replace(SMALL, correction_share=0.0, hold_closures=False, as_recorded=False)).fit(
        recorded[:10]
    )
    assert alone.correction_ is None
    curves = alone.curves_.components(alone.curves_.place(EVERY_PHONE, TIMES))
    expected = alone.space_.decode(curves).reshape(-1, 12, 3)
    assert np.abs(alone.synthesise(EVERY_PHONE, TIMES) - expected).max() < 0.5  # facing lips aside


def test_odd_input(model, recorded):
    silent = model.synthesise(Tier("phones", ()), TIMES)
    assert np.allclose(silent, silent[0])
    assert model.synthesise(EVERY_PHONE, np.zeros(0)).shape == (0, 12, 3)
    with pytest.raises(InputError, match="unknown phone"):
        model.synthesise(tier(["SIL", "Q", "SIL"]), TIMES)
    with pytest.raises(InputError, match="no take"):
        SpeechMotion(SMALL).fit([])
    other = take("other", tier(["SIL", "M", "SIL"]))
    other = replace(other, markers=MarkerTrack(NAMES[:5], other.markers.positions[:, :5], other.markers.rate))
    with pytest.raises(InputError, match="other markers"):
        SpeechMotion(SMALL).fit([recorded[0], other])
    with pytest.raises(InputError, match="has a frame with speech"):
        SpeechMotion(SMALL).fit([take("silence", tier(["SIL", "SIL"]))])


def test_takes_with_unseen_frames_are_learned_from_the_rest(recorded):
    positions = recorded[0].markers.positions.copy()
    positions[3:9, 2] = np.nan
    holed = replace(recorded[0], markers=MarkerTrack(NAMES, positions, recorded[0].markers.rate))
    made = SpeechMotion(SMALL).fit([holed, *recorded[1:5]])
    assert np.isfinite(made.synthesise(EVERY_PHONE, TIMES)).all()


def test_evidence_names_the_strongest(model, recorded):
    labels = [phone.label for phone in recorded[0].phones]
    assert len(model.evidence(recorded[0].phones)) == len(labels) - 1
    assert set(model.evidence(EVERY_PHONE)) <= {"triphone", "diphone", "class", "none"}
    assert model.evidence(tier(["OY", "ZH"])) != ("diphone",)


@pytest.fixture(scope="module")
def learned(recorded):
    return learn(recorded, SETTINGS, name="made up", about={"licence": "none"})


def test_a_saved_performer_moves_bit_for_bit_as_before(learned, tmp_path):
    learned.motion.edits_ = learned.motion.with_key_shape("AA", learned.motion.key_shapes("AA") + 1.0).edits_
    save_learned(learned, tmp_path / "a.mien")
    save_learned(learned, tmp_path / "b.mien")
    assert (tmp_path / "a.mien").read_bytes() == (tmp_path / "b.mien").read_bytes()
    again = load_learned(tmp_path / "a.mien")
    for mine, theirs in ((again.motion, learned.motion), (again.coarticulation, learned.coarticulation)):
        assert np.array_equal(mine.synthesise(EVERY_PHONE, TIMES), theirs.synthesise(EVERY_PHONE, TIMES))
        assert mine.evidence(EVERY_PHONE) == theirs.evidence(EVERY_PHONE)
        assert mine.settings == theirs.settings
        assert mine.mouth_.names == theirs.mouth_.names
    assert again.name == "made up"
    assert again.about == {"licence": "none"}
    assert again.trained_on == learned.trained_on
    assert np.array_equal(again.fitting_cost, learned.fitting_cost)


def test_learning_twice_gives_the_same_file(recorded, tmp_path):
    for name in ("a", "b"):
        save_learned(learn(recorded[:8], SETTINGS), tmp_path / f"{name}.mien")
    assert (tmp_path / "a.mien").read_bytes() == (tmp_path / "b.mien").read_bytes()


def test_files_that_are_no_performer_are_refused(learned, tmp_path):
    with pytest.raises(InputError, match="no such file"):
        load_learned(tmp_path / "missing.mien")
    (tmp_path / "text.mien").write_text("hello")
    with pytest.raises(InputError, match="cannot be read as a performer"):
        load_learned(tmp_path / "text.mien")
    with zipfile.ZipFile(tmp_path / "newer.mien", "w") as archive:
        archive.writestr("performer.json", '{"format": "mien-performer", "version": 5}')
    with pytest.raises(InputError, match="expected mien-performer 4, found mien-performer 5"):
        load_learned(tmp_path / "newer.mien")
    save_learned(learned, tmp_path / "cut.mien")
    (tmp_path / "cut.mien").write_bytes((tmp_path / "cut.mien").read_bytes()[:5000])
    with pytest.raises(InputError, match="cannot be read as a performer"):
        load_learned(tmp_path / "cut.mien")


def test_learning_says_how_far_it_is_and_what_it_learned_from(recorded):
    heard = []
    made = learn(recorded[:8], SETTINGS, lambda done, total, what: heard.append((done, total, what)))
    assert [done for done, _, _ in heard] == list(range(1, heard[0][1] + 1))
    assert heard[-1][2] == "recordings"
    assert made.trained_on == tuple(sorted(identity_of(t) for t in recorded[:8]))


def test_a_corpus_is_learned_without_what_is_left_out(recorded, tmp_path):
    corpus = Corpus.create(tmp_path / "corpus", {"layout": "mediapipe-218", "licence": "CC BY 4.0"})
    for t in recorded[:10]:
        corpus.add(t)
    corpus.add(replace(recorded[10], emotion="angry", sentence="said only in anger"))
    made = learn_corpus(corpus, SETTINGS, exclude_words=["WORD1"], exclude_names=["word0-0"])
    kept = [t for t in recorded[1:11] if not t.name.startswith("word1-")]  # the angry one is a node of the graph
    assert sorted(made.trained_on) == sorted(corpus.identity(t.name) for t in kept)
    assert made.about == {"licence": "CC BY 4.0"}
    with pytest.raises(InputError, match="not in this corpus: nobody"):
        learn_corpus(corpus, SETTINGS, exclude_names=["nobody"])
    with pytest.raises(InputError, match="no take is left to learn from"):
        learn_corpus(corpus, SETTINGS, exclude_words=[f"word{k}" for k in range(5)])


def test_a_cluster_learns_the_same_to_the_byte(recorded, tmp_path):
    distributed = pytest.importorskip("distributed")
    corpus = Corpus.create(tmp_path / "corpus", {"layout": "mediapipe-218"})
    for t in recorded[:6]:
        corpus.add(t)
    save_learned(learn_corpus(corpus, SETTINGS), tmp_path / "here.mien")
    with distributed.LocalCluster(n_workers=1, processes=False, dashboard_address=None) as cluster:
        there = learn_corpus(corpus, SETTINGS, cluster=cluster.scheduler_address)
    save_learned(there, tmp_path / "there.mien")
    assert (tmp_path / "here.mien").read_bytes() == (tmp_path / "there.mien").read_bytes()


def test_files_of_version_3_move_their_markers(learned, tmp_path):
    save_learned(learned, tmp_path / "now.mien")
    with zipfile.ZipFile(tmp_path / "now.mien") as now, zipfile.ZipFile(tmp_path / "old.mien", "w") as old:
        for name in now.namelist():
            content = now.read(name)
            if name == "performer.json":
                told = json.loads(content) | {"version": 3, "layout": "mediapipe-218", "markers": NAMES}
                del told["mouth"]
                speech = told["settings"]["speech"]
                speech["lip_emphasis"] = 1.5
                for newer in ("as_recorded", "learn_in"):
                    del speech[newer]
                content = json.dumps(told).encode()
            if name == "speech/closing.npy":
                way = BytesIO()
                np.save(way, learned.motion.closure_.closing_.reshape(-1, 3))
                content = way.getvalue()
            if name != "speech/spread.npy":
                old.writestr(name, content, zipfile.ZIP_STORED)
    again = load_learned(tmp_path / "old.mien").motion
    plain = copy(learned.motion)
    plain.spread_ = None
    assert again.mouth_.names == NAMES
    assert np.array_equal(again.synthesise(EVERY_PHONE, TIMES), plain.synthesise(EVERY_PHONE, TIMES))
