from __future__ import annotations

import pytest

import mien
from mien.api.diagnosis import Finding, Report
from mien.cli import main


def test_doctor_names_the_parts_their_licences_and_the_verdict(capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["doctor"]) == 0
    table = capsys.readouterr().out
    for part in ("voice", "pocketsphinx", "face default", "codec libx264", "Apache-2.0", "CC0", "mien is ready."):
        assert part in table


def test_a_missing_part_makes_the_report_unhealthy() -> None:
    report = Report((Finding("voice", "missing", "pip install it"),))
    assert not report.healthy
    assert "not ready" in str(report)
    assert mien.doctor().healthy
