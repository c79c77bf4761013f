"""Round phones become as round and as full as another speaker's; others stay."""

from __future__ import annotations

from mien.motion.mouth.rounding import rounded
from mien.motion.performers import load_learned_performer


def test_round_phones_are_rounder_and_fuller_and_others_stay() -> None:
    default, mandarin = (load_learned_performer(name).motion for name in ("default", "mandarin"))
    made = rounded(mandarin, default, phones=("UW",), share=1.0)
    names, theirs = mandarin.mouth_.names, default.mouth_.names
    before, after, wanted = mandarin.key_shapes("UW")[0], made.key_shapes("UW")[0], default.key_shapes("UW")[0]
    pucker = names.index("mouthPucker")
    least = max(before[pucker], wanted[theirs.index("mouthPucker")])
    assert after[pucker] > least - 0.1
    roll = names.index("mouthRollUpper")
    assert after[roll] <= before[roll] + 0.05
    assert (made.key_shapes("IY") == mandarin.key_shapes("IY")).all()
    assert (made.key_shapes("W") == mandarin.key_shapes("W")).all()


def test_round_lips_part_by_a_funnel_and_not_by_a_lower_lip_drawn_down() -> None:
    mandarin = load_learned_performer("mandarin").motion
    names = mandarin.mouth_.names
    funnel, down = names.index("mouthFunnel"), [names.index(f"mouthLowerDown{side}") for side in ("Left", "Right")]
    shapes = mandarin.key_shapes("UW")
    shapes[:, down] += 0.4
    drawn = mandarin.with_key_shape("UW", shapes)
    made, before = rounded(drawn, mandarin, phones=("UW",), share=1.0).key_shapes("UW"), drawn.key_shapes("UW")
    assert made[:, down].max() < before[:, down].max()
    assert (made[:, funnel] > before[:, funnel]).all()
