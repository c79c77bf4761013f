import numpy as np

from mien.face.cast.made_person import cast_names, person_named
from mien.face.cast.people import drawn_features, head_weights
from mien.face.head_space import head_space


def test_all_heads_of_the_cast_differ() -> None:
    people = [person_named(name) for name in cast_names()]
    space = head_space()
    face = space.rest[:, 2] > -20
    heads = []
    for person in people:
        weights = head_weights(person.sex, person.age, person.shares, person.features, (person.weight, person.muscle))
        head = space.shape(weights)[face]
        heads.append(head - head.mean(axis=0))
    for number, one in enumerate(heads):
        for other in heads[:number]:
            assert np.sqrt(((one - other) ** 2).sum(axis=1).mean()) > 1.5  # mm


def test_features_come_from_the_seed_and_variety_scales_them() -> None:
    assert drawn_features(3) == drawn_features(3)
    assert drawn_features(3).keys() != drawn_features(4).keys()
    assert sum(drawn_features(3, 0.0).values()) == 0


def test_age_and_sex_move_the_head() -> None:
    mix = {"caucasian": 1.0}
    assert np.abs(head_weights(1, 25, mix) - head_weights(0, 25, mix)).max() > 0.3
    assert np.abs(head_weights(1, 25, mix) - head_weights(1, 80, mix)).max() > 0.3
