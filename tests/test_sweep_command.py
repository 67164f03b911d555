"""`sdfstent sweep`: what it says, its exit codes, `--dry-run`, `--table` and `--status`."""

from __future__ import annotations

import pytest
from cohort_cases import bytes_of, tube_folder, write_sweep

from SDFStentLib.cli import main
from SDFStentLib.cohort import Tally


@pytest.fixture
def there(tmp_path, monkeypatch):
    tube_folder(tmp_path)
    monkeypatch.chdir(tmp_path)
    return tmp_path


def test_a_sweep_is_carried_out_said_and_can_be_asked_for(there, capsys):
    write_sweep(there, axes={"diameter": [6, 6.5]}, store="moved")
    assert main(["sweep", "sweep.json", "-o", "out", "--workers", "1"]) == 0
    out = capsys.readouterr().out
    assert "2 of 2 cases: 2 certified for meshing." in out
    assert "Wrote out in " in out
    before = bytes_of(there / "out")
    assert main(["sweep", "--status", "out"]) == 0
    assert capsys.readouterr().out == "Finished: 2 of 2 cases: 2 certified for meshing.\n"
    (there / "out" / "manifest.csv").unlink()
    assert main(["sweep", "--table", "out"]) == 0
    assert "manifest.csv" in capsys.readouterr().out
    assert main(["sweep", "sweep.json", "-o", "out"]) == 0
    assert bytes_of(there / "out") == before


def test_a_dry_run_tells_count_cases_time_and_disk_and_writes_nothing(there, capsys):
    write_sweep(there)
    before = sorted(there.iterdir())
    assert main(["sweep", "sweep.json", "--dry-run", "--workers", "2"]) == 0
    lines = capsys.readouterr().out.splitlines()
    assert lines[0] == "6 cases, 1 patient(s)."
    assert [line.split(":")[0] for line in lines[1:6]] == ["1", "2", "3", "4", "5"]
    assert '"diameter": 6.0' in lines[1]
    assert "By 3 cases carried out now: " in lines[6]
    assert " on 2 process(es), " in lines[7]
    assert lines[7].endswith("MB of disk.")
    assert sorted(there.iterdir()) == before


def test_a_terminal_shows_counts_rate_and_time_left(there, capsys, monkeypatch):
    write_sweep(there, axes={"diameter": [6, 6.5, 40]})
    monkeypatch.setattr("sys.stderr.isatty", lambda: True)
    main(["sweep", "sweep.json", "-o", "out", "--workers", "1"])
    bar = capsys.readouterr().err
    assert "Sweeping [" in bar
    last = bar.rstrip().split("\r")[-1].strip() or bar.rstrip().split("\r")[-2]
    assert "100 % 2 certified for meshing, 1 failed, " in last
    assert "/s, 0 s left" in last


def test_the_counts_tell_rate_and_time_left_of_this_run_alone():
    tally = Tally(
        total=1000, certified=90, uncertified=3, excluded=5, failed=2, found=50, seconds=25
    )
    assert (tally.finished, tally.fraction, tally.rate) == (100, 0.1, 2)
    assert tally.seconds_left == 450
    note = (
        "90 certified for meshing, 2 failed, 3 not certified for meshing, 5 excluded, 2/s, "
        "8 min left"
    )
    assert tally.note() == note
    assert Tally(10).note() == "0 certified for meshing, 0 failed"
