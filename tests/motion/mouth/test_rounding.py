"""Round phones become as round and as full as another speaker's; others stay."""

from __future__ import annotations

from mien.motion.mouth.rounding import rounded
from mien.motion.performers import load_learned_performer


def test_round_phones_are_rounder_and_fuller_and_others_stay() -> None:
    default, mandarin = (load_learned_performer(name).motion for name in ("default", "mandarin"))
    made = rounded(mandarin, default, phones=("UW",))
    names, theirs = mandarin.mouth_.names, default.mouth_.names
    before, after, wanted = mandarin.key_shapes("UW")[0], made.key_shapes("UW")[0], default.key_shapes("UW")[0]
    pucker = names.index("mouthPucker")
    least = max(before[pucker], wanted[theirs.index("mouthPucker")])
    assert after[pucker] > least - 0.1
    roll = names.index("mouthRollUpper")
    assert after[roll] <= before[roll] + 0.05
    assert (made.key_shapes("IY") == mandarin.key_shapes("IY")).all()
    assert (made.key_shapes("W") == mandarin.key_shapes("W")).all()
