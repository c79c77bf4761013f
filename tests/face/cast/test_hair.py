from dataclasses import replace

import numpy as np
import pytest

from mien.face.cast.hair import hair_parts
from mien.face.cast.made_person import made_up
from mien.face.head_space import head_space
from mien.face.library import load_face


@pytest.mark.parametrize("cut", ["bob", "long", "bun"])
def test_no_strand_hangs_into_the_face(cut: str) -> None:
    person = replace(made_up("f", 30, "european", seed=5), hair=cut)
    parts = {part.name: part for part in hair_parts(head_space(), load_face("default"), person)}
    x, y, z = parts["hair"].vertices.T
    assert not ((np.abs(x) < 50) & (y < 45) & (z > 10)).any()
