"""What changes often changes in one file: a table of one's own, or one entry point of another package."""

from __future__ import annotations

import os
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

from mien.core.emotions import emotions
from mien.core.errors import InputError
from mien.motion.alive.idle import HandMadeIdle
from tests.utterances import utterance

BORED = """
arousal = 0.1
episodes = [4.0, 0.1]
lean = 0.0
head = { headPitch = -4.0 }
[units]
AU41 = [0.6, 0.05]
[spoken]
[voice]
rate = 0.8
[manner]
blinks = 0.7
"""
LANGUAGE = """
tag = "xx"
name = "Toy"
reader = "letters"
[letters]
a = ["ɑ"]
m = ["m"]
[phones]
"""
PACKAGE = '''
"""A package that adds one of each."""
import numpy as np

from mien.core import channels
from mien.formats import Exporter
from mien.motion.mouth.hand_made_mouth import MouthMotion
from mien.motion.performer import Performer
from mien.speech.voices.voice import Availability, Voice


def write(animation, path, face, progress):
    path.write_text(f"{len(animation.channels)} frames")
    return ()


FORMAT = Exporter(".frames", "how many frames there are", "everything else", False, write)


def nothing_in_common(reference, estimate):
    return {"frames_apart_s": 3.0}


class Gape:
    """A mouth that stands open."""

    def perform(self, utterance, rate):
        frames = rate.frames_covering(utterance.duration)
        values = np.zeros((frames, len(channels.ALL)))
        values[:, channels.ALL.index("jawOpen")] = 0.5
        return MouthMotion(values, np.zeros(frames))


def gaper():
    from dataclasses import replace

    return replace(Performer.hand_made(), name="gaper", mouth=Gape())


class Hum(Voice):
    name, language, engine = "hum", "en-US", "a sine"
    licence = lineage = "ours"
    own_pronunciation = realign = False

    def availability(self):
        return Availability(True, "here")

    def _speak(self, sentences, seed):
        raise NotImplementedError


HUM = Hum()
'''
ENTRY_POINTS = """
[mien.formats]
frames = addition:FORMAT
[mien.metrics]
apart = addition:nothing_in_common
[mien.performers]
gaper = addition:gaper
[mien.voices]
hum = addition:HUM
"""


def run(code: str, **environment: str) -> str:
    """What a program prints in a process of its own."""
    done = subprocess.run(
        [sys.executable, "-c", code],
        capture_output=True,
        text=True,
        check=False,
        cwd=Path(__file__).parents[1],
        env={**os.environ, **environment},
    )
    assert done.returncode == 0, done.stderr[-2000:]
    return done.stdout


@pytest.fixture(scope="module")
def tables(tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("tables")
    for name, text in {
        "performance/emotions/bored.toml": BORED,
        "languages/xx.toml": LANGUAGE,
        "recipes/mine.toml": 'name = "mine"\nabout = "a rig of ours"\nreader = "livelink"\n',
    }.items():
        (folder / name).parent.mkdir(parents=True, exist_ok=True)
        (folder / name).write_text(text)
    return folder


@pytest.fixture(scope="module")
def package(tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("packages")
    (folder / "addition.py").write_text(PACKAGE)
    about = folder / "addition-1.0.dist-info"
    about.mkdir()
    (about / "METADATA").write_text("Metadata-Version: 2.1\nName: addition\nVersion: 1.0\n")
    (about / "entry_points.txt").write_text(ENTRY_POINTS)
    return folder


def test_an_emotion_is_one_table(tables: Path) -> None:
    code = """
from mien.core import channels
from mien.core.timeline import FrameRate
from mien.motion.performer import Performer
from mien.pipeline.options import score_of
from mien.pipeline.perform import perform
from mien.cli import main
from tests.utterances import utterance
said = utterance(("SIL", 0.2), ("AA", 0.4), ("SIL", 0.2))
moved = perform(said, score_of("bored"), Performer.hand_made(), FrameRate.of(30)).channels.values
still = perform(said, score_of(None), Performer.hand_made(), FrameRate.of(30)).channels.values
pitch = channels.ALL.index("headPitch")
print("BORED" if (moved - still)[:, pitch].mean() < -2 else (moved - still)[:, pitch].mean())
main(["emotions"])
"""
    printed = run(code, MIEN_TABLES=str(tables))
    assert printed.startswith("BORED")
    assert "bored:0.6" in printed


@pytest.mark.parametrize(
    ("was", "now", "said"),
    [
        ("AU41 = [0.6, 0.05]", "AU99 = [1, 1]", "AU99"),
        ("AU41 = [0.6, 0.05]", "AU41 = 0.6", "units.AU41 is two numbers"),
        ("arousal = 0.1", 'arousal = "low"', "arousal is a number"),
        ("episodes = [4.0, 0.1]", "episodes = [4.0]", "episodes is two numbers"),
        ("headPitch", "neckPitch", "neckPitch"),
        ("lean = 0.0", "", "needs lean too"),
        ("blinks = 0.7", "blinks = nan", "manner.blinks is a number"),
    ],
)
def test_an_emotion_that_is_none_is_refused_by_its_file(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, was: str, now: str, said: str
) -> None:
    table = tmp_path / "performance/emotions/bored.toml"
    table.parent.mkdir(parents=True)
    table.write_text(BORED.replace(was, now))
    monkeypatch.setenv("MIEN_TABLES", str(tmp_path))
    with pytest.raises(InputError, match=said) as caught:
        emotions.__wrapped__()
    assert "bored.toml" in str(caught.value)


def test_a_language_is_one_table(tables: Path) -> None:
    code = """
from mien.cli import main
from mien.text.languages import find_language, read_in
print([word.phones for word in read_in(find_language("xx"), "mama").words])
main(["languages"])
"""
    printed = run(code, MIEN_TABLES=str(tables))
    assert "('m', 'ɑ', 'm', 'ɑ')" in printed
    assert "Toy" in printed


def test_a_recipe_is_one_table_and_the_doctor_lists_what_is_your_own(tables: Path) -> None:
    code = """
from mien.api.diagnosis import doctor
from mien.corpus.recipes import known_recipes
print(known_recipes(), doctor())
"""
    printed = run(code, MIEN_TABLES=str(tables))
    assert "'mine'" in printed
    assert "languages/xx.toml" in printed


def test_a_folder_of_tables_that_is_not_there_is_one_line(tmp_path: Path) -> None:
    code = "from mien.cli import main; import sys; sys.exit(main(['languages']) != 2)"
    run(code, MIEN_TABLES=str(tmp_path / "nowhere"))


def test_a_format_a_metric_a_voice_and_a_mouth_model_are_one_entry_point_each(package: Path, tmp_path: Path) -> None:
    code = f"""
from pathlib import Path
from mien.cli import main
from mien.core import channels
from mien.core.timeline import FrameRate
from mien.formats import save
from mien.metrics.scoring import tasks
from mien.motion.performers import load_performer
from mien.pipeline.options import score_of
from mien.pipeline.perform import perform
from mien.speech.voices import get_voice
from tests.utterances import utterance
line = perform(utterance(("AA", 0.5)), score_of(None), load_performer("gaper"), FrameRate.of(30))
print(line.channels.values[:, channels.ALL.index("jawOpen")].max() >= 0.5)
out = Path({str(tmp_path / "line.frames")!r})
save(line, out)
print(out.read_text(), tasks()["apart"](None, None), get_voice("hum").engine)
for listed in ("formats", "voices", "performers"):
    main([listed])
"""
    path = os.pathsep.join([str(package), os.environ.get("PYTHONPATH", "")])
    printed = run(code, PYTHONPATH=path)
    assert printed.startswith("True\n15 frames {'frames_apart_s': 3.0} a sine")
    assert ".frames " in printed
    assert "hum " in printed
    assert "gaper " in printed


def test_the_rate_of_blinks_is_an_option() -> None:
    said = utterance(("AA", 60.0))
    few, many = (len(HandMadeIdle.of(f"blinks={n}").blink_times(said, np.random.default_rng(1))) for n in (6, 40))
    assert 3 <= few <= 10
    assert 25 <= many <= 45


@pytest.mark.parametrize("signs", ["gaze=3", "blinks=x", "blinks=-1", "blinks=1000", "blinks=nan", "off,gaze", "blink"])
def test_signs_of_life_that_are_none_are_refused(signs: str) -> None:
    with pytest.raises(InputError):
        HandMadeIdle.of(signs)
