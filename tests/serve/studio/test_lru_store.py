import pytest

from mien.serve.studio.lru_store import Kept, Missing, new_id


def test_the_least_recently_used_gives_way():
    gone = []
    kept = Kept("thing", 2, gone=gone.append)
    a, b = kept.put("a"), kept.put("b")
    kept.get(a)
    kept.put("c")
    assert gone == ["b"]
    assert kept.get(a) == "a"
    with pytest.raises(Missing):
        kept.get(b)


def test_bytes_are_bounded_but_the_newest_stays():
    gone = []
    kept = Kept("thing", 10, 100, gone.append)
    kept.put("a", 60)
    kept.put("b", 60)
    assert gone == ["a"]
    kept.put("c", 500)
    assert gone == ["a", "b"]
    assert list(kept) == ["c"]


def test_a_name_is_kept_anew():
    gone = []
    kept = Kept("thing", 2, gone=gone.append)
    name = kept.put("a")
    kept.put("b", name=name)
    assert kept.get(name) == "b"
    kept.drop(name)
    kept.drop(name)
    assert gone == ["b"]


def test_ids_differ_and_are_safe_in_addresses():
    ids = {new_id() for _ in range(200)}
    assert len(ids) == 200
    assert all(set(one) <= set("abcdefghijklmnopqrstuvwxyzABCDEFGHIJKLMNOPQRSTUVWXYZ0123456789-_") for one in ids)
