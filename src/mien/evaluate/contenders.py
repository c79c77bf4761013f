"""The rows of a table of scores: baselines and learned models, by name."""

from __future__ import annotations

from collections.abc import Callable, Sequence

from mien.errors import unknown_name
from mien.evaluate.baselines import Cosine, MeanPose, Model, Ridge
from mien.evaluate.dominance import Dominance
from mien.evaluate.perceptron import Perceptron

__all__ = ["contenders"]


def contenders(names: Sequence[str] | None = None, *, unseen_words: bool = False) -> dict[str, Callable[[], Model]]:
    """Makers of untrained models, in the order of the table.

    Parameters
    ----------
    names : sequence of str or None
        Only these; None takes all.
    unseen_words : bool
        Ridge and perceptron see less context (0.16 s in place of 0.32 s to each side), as does them good there.

    Raises
    ------
    InputError
        If a name is not known.

    Examples
    --------
    >>> list(contenders(["ridge", "cosine"]))
    ['cosine', 'ridge']
    """
    reach = 0.16 if unseen_words else 0.32
    every: dict[str, Callable[[], Model]] = {
        "mean pose": MeanPose,
        "cosine": Cosine,
        "dominance": Dominance,
        "ridge": lambda: Ridge(reach),
        "perceptron": lambda: Perceptron(reach=reach),
    }
    if names is None:
        return every
    for name in names:
        if name not in every:
            raise unknown_name("model", name, every)
    return {name: make for name, make in every.items() if name in names}
