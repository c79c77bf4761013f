"""Work out what comes with mien and does not depend on the line: ``python tools/derive.py`` (`mien.core.derived`).

Run it after a change of the default face, a marker layout or the table of expressions; a test tells when it is due.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from typing import Any

from numpy.typing import NDArray

from mien.core.derived import write_derived
from mien.face import marker_sites
from mien.motion.expression import hand_made_performance

MADE: dict[str, tuple[Sequence[str], Callable[[], Mapping[str, NDArray[Any]]]]] = {
    marker_sites.DERIVED: (marker_sites.sources(), marker_sites.derived_sites),
    hand_made_performance.DERIVED: (hand_made_performance.sources(), hand_made_performance.derived_axes),
}
"""Files of ``assets`` that each is worked out from, and what works it out."""


def main() -> None:
    """Write all of them."""
    for name, (sources, made) in MADE.items():
        print(write_derived(name, sources, made()))


if __name__ == "__main__":
    main()
