"""Identification of six facial expressions, static and dynamic, with a rating of how natural each looks.

    mien stimuli design.csv -o stimuli
    python experiment.py

The second line needs PsychoPy (https://www.psychopy.org), which is no part of mien. After Frydrych et al. (2003,
section 4) and Kätsyri et al. (2003): every expression as a picture and as a short film, in an order of chance for each
participant; six keys to name it, then a number from 1 to 7. What was answered is in data/ after every trial.
"""

from __future__ import annotations

from pathlib import Path

HERE = Path(__file__).parent
KEYS = {"a": "angry", "d": "disgusted", "f": "afraid", "h": "happy", "s": "sad", "u": "surprised"}
RATINGS = [str(number) for number in range(1, 8)]
STOP = "escape"
GREY = (0.0039, 0.0039, 0.0039)  # #808080, the background of the stimuli, in PsychoPy's colours from -1 to 1
STILL_SECONDS = 2.5  # as long as a film lasts
INSTRUCTION = (
    "You will see faces, one after another.\n\nFirst say what each of them expresses:\n\n"
    + "\n".join(f"{key.upper()}   {name}" for key, name in KEYS.items())
    + "\n\nThen how natural it looked, from 1 (not at all) to 7 (entirely).\n\nEscape ends.  Any key begins."
)


class ParticipantStoppedError(Exception):
    """The participant pressed Escape."""


def ask(window, text, keys):
    """Show a question until one of the keys is pressed; returns the key and the seconds since the question was seen."""
    from psychopy import core, event, visual

    visual.TextStim(window, text=text, color="black", height=0.05, wrapWidth=1.4).draw()
    clock = core.Clock()
    window.callOnFlip(clock.reset)
    window.callOnFlip(event.clearEvents)
    window.flip()
    pressed = event.waitKeys(keyList=None if keys is None else [*keys, STOP], timeStamped=clock)
    key, seconds = pressed[0]
    if key == STOP:
        raise ParticipantStoppedError
    return key, seconds


def show(window, stimulus):
    """Show a picture or a film for as long as it lasts.

    Returns the seconds from the flip that first showed it to the flip that took it off, and the seconds between the
    flips of a film.
    """
    from psychopy import core, visual

    clock = core.Clock()
    window.callOnFlip(clock.reset)
    if stimulus.suffix == ".png":
        visual.ImageStim(window, image=str(stimulus)).draw()
        window.flip()
        core.wait(STILL_SECONDS)
        intervals = []
    else:
        film = visual.MovieStim(window, filename=str(stimulus), noAudio=True, autoStart=False)
        film.play()
        window.frameIntervals, window.recordFrameIntervals = [], True
        while not film.isFinished:
            film.draw()
            window.flip()
        window.recordFrameIntervals = False
        intervals = list(window.frameIntervals)
        film.stop()
    window.flip()
    return clock.getTime(), intervals


def trial(window, condition):
    """One trial: the face, the question, the rating. Returns what goes into the data."""
    shown, intervals = show(window, HERE / condition["stimulus"])
    question = "   ".join(f"{key.upper()} {name}" for key, name in KEYS.items())
    key, seconds = ask(window, f"What did the face express?\n\n{question}", KEYS)
    rating, _ = ask(window, "How natural did it look?\n\n1  2  3  4  5  6  7", RATINGS)
    return {
        "shown_seconds": round(shown, 4),
        "answer": KEYS[key],
        "correct": int(key == condition["correct_key"]),
        "reaction_seconds": round(seconds, 4),
        "naturalness": int(rating),
        "longest_frame_ms": round(1000 * max(intervals, default=0.0), 2),
        "frame_intervals_ms": " ".join(f"{1000 * interval:.2f}" for interval in intervals),
    }


def missing(conditions):
    """Stimuli that were not made."""
    return [item["stimulus"] for item in conditions if not (HERE / item["stimulus"]).is_file()]


def run(participant, seed):
    """All trials of one participant; returns how many were answered."""
    from psychopy import data, visual

    conditions = data.importConditions(str(HERE / "conditions.csv"))
    absent = missing(conditions)
    if absent:
        raise SystemExit(f"{absent[0]} is not there: run 'mien stimuli design.csv -o stimuli' first")
    (HERE / "data").mkdir(exist_ok=True)
    written = HERE / "data" / f"{participant}-{data.getDateStr()}"
    experiment = data.ExperimentHandler(
        name="six_expressions", extraInfo={"participant": participant, "seed": seed}, dataFileName=str(written)
    )
    trials = data.TrialHandler(conditions, nReps=1, method="random", seed=seed)
    experiment.addLoop(trials)
    window = visual.Window(fullscr=True, color=GREY, units="height")
    answered = 0
    try:
        ask(window, INSTRUCTION, None)
        for condition in trials:
            for name, value in trial(window, condition).items():
                trials.addData(name, value)
            experiment.nextEntry()
            answered += 1
            experiment.saveAsWideText(f"{written}.csv", appendFile=False, fileCollisionMethod="overwrite")
        ask(window, "That was all. Thank you!", None)
    except ParticipantStoppedError:
        pass
    finally:
        window.close()
    return answered


if __name__ == "__main__":
    from psychopy import gui

    about = {"participant": "p01", "seed": "1"}
    if gui.DlgFromDict(about, title="Six expressions").OK:
        run(about["participant"], int(about["seed"]))
