from __future__ import annotations

from pathlib import Path

import pytest

from mien.core.errors import InputError
from mien.core.table_rows import parsed_table, read_rows


@pytest.mark.parametrize("encoding", ["utf-8", "utf-8-sig", "utf-16", "cp1252"])
@pytest.mark.parametrize("mark", [",", ";", "\t"])
@pytest.mark.parametrize("said", [False, True])
def test_marks_and_encodings(tmp_path: Path, encoding: str, mark: str, said: bool) -> None:
    text = "\r\n".join(
        [*([f"sep={mark}"] if said else []), mark.join(("naam", "é")), "", mark.join((" a ", '"1, 2; 3"'))]
    )
    (tmp_path / "a.csv").write_bytes(text.encode(encoding))
    table = read_rows(tmp_path / "a.csv")
    assert table.rows == [(1 + said, ["naam", "é"]), (3 + said, ["a", "1, 2; 3"])]
    assert len(table.notes) == (encoding == "cp1252")


def test_a_decimal_comma_is_one_only_between_other_marks() -> None:
    semicolons = parsed_table("0,5;1,0\n1,5;0,25", "a.csv")
    assert [[semicolons.spelt(cell) for cell in row] for _, row in semicolons.rows] == [["0.5", "1.0"], ["1.5", "0.25"]]
    assert semicolons.spelt("well, then") == "well, then"
    assert parsed_table("0.5,1.0", "a.csv").spelt("0,5") == "0,5"


def test_a_quote_that_never_closes_names_the_line() -> None:
    with pytest.raises(InputError, match=r"a.csv, line 3: expected a table"):
        parsed_table('name,text\na,"b\nc', "a.csv")
