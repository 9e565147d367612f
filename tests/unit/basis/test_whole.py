"""Files that are whole or absent, and folders that two runs cannot share."""

from __future__ import annotations

import errno
import os
import signal
import subprocess
import sys

import pytest

from orchestrator.app import cli
from orchestrator.basis.atomic_files import (
    locked,
    read_written,
    replacing,
    sealed,
    sweep,
    together,
    unsealed,
    write_bytes,
)
from orchestrator.basis.errors import CaseError
from orchestrator.storage import write_csv, write_json
from tests.support.disks import read_only, small_disk
from tests.support.paths import DATA, PROJECT

TOWER = DATA / "tower_5_blocks.json"
SHORT = ["--model", "micro", "--set", "stepping.final_displacement=2mm"]
KILLED = """
import os, signal, sys
from pathlib import Path
from orchestrator.basis.atomic_files import replacing
with replacing(Path(sys.argv[1])) as temporary:
    temporary.write_text("half")
    os.kill(os.getpid(), signal.SIGKILL)
"""
HOLDER = """
import sys, time
from pathlib import Path
from orchestrator.basis.atomic_files import locked
with locked(Path(sys.argv[1])):
    print("held", flush=True)
    time.sleep(60)
"""


def leave_half_written(path):
    """Leave what a run leaves that is killed while it writes a file."""
    assert subprocess.run([sys.executable, "-c", KILLED, path], cwd=PROJECT, check=False).returncode == -9


@pytest.fixture(name="small_disk")
def disk(tmp_path, request):
    """A file system of 300 kB, or of what the test asks for."""
    folder = tmp_path / "disk"
    folder.mkdir()
    with small_disk(folder, getattr(request, "param", 300)):
        yield folder


@pytest.fixture(name="read_only")
def closed(tmp_path):
    """A folder in which nobody may write, not even root, with a file in it."""
    folder = tmp_path / "disk"
    folder.mkdir()
    (folder / "older").write_text("older")
    if os.getuid() == 0:
        with read_only(folder):
            yield folder
        return
    folder.chmod(0o500)
    yield folder
    folder.chmod(0o700)


def test_full_disk_is_named_and_the_older_file_stays(small_disk):
    path = small_disk / "curve.csv"
    write_csv(path, ("a",), [(1,)])
    with pytest.raises(OSError, match="No space left") as caught:
        write_json(path, "x" * 400_000)
    assert (caught.value.errno, caught.value.filename) == (errno.ENOSPC, str(path))
    assert path.read_text() == "a\n1\n"
    assert list(small_disk.iterdir()) == [path]


@pytest.mark.parametrize("small_disk", [300, 600, 1250], indirect=True)
def test_a_run_on_a_full_disk_ends_with_one_line_and_keeps_what_it_has(small_disk, capsys):
    """Full while drawing, while increments are stored, and while they are gathered (where HDF5 would crash)."""
    (small_disk / "older").write_bytes(b"older")
    command = ["run", str(TOWER), "--output", str(small_disk / "run"), "--quiet", *SHORT]
    assert cli.main(command) == 1
    (line,) = capsys.readouterr().err.splitlines()
    assert str(small_disk / "run") in line
    assert line.endswith("No space left on device")
    assert not list((small_disk / "run").rglob(".*"))
    assert (small_disk / "older").read_bytes() == b"older"


def test_a_run_into_a_read_only_folder_ends_with_one_line(read_only, capsys):
    assert cli.main(["run", str(TOWER), "--output", str(read_only / "run"), "--quiet"]) == 2
    (line,) = capsys.readouterr().err.splitlines()
    reasons = ("read-only file system", "permission denied")
    said = f"{read_only / 'run'}: --output: cannot be written ({{}}); give another folder"
    assert line in [said.format(reason) for reason in reasons]
    assert [path.name for path in read_only.iterdir()] == ["older"]


def test_two_runs_cannot_share_a_folder_and_the_second_touches_nothing(tmp_path, capsys):
    with subprocess.Popen(
        [sys.executable, "-c", HOLDER, tmp_path], stdout=subprocess.PIPE, text=True, cwd=PROJECT
    ) as holder:
        assert holder.stdout.readline() == "held\n"
        before = sorted(tmp_path.rglob("*"))
        assert cli.main(["run", str(TOWER), "--output", str(tmp_path), "--quiet"]) == 2
        (line,) = capsys.readouterr().err.splitlines()
        assert f"{tmp_path}: is in use by process {holder.pid} on " in line
        assert "--output" in line
        assert sorted(tmp_path.rglob("*")) == before
        holder.kill()
        holder.wait()
    assert (tmp_path / ".lock").exists(), "left by the dead process"
    with locked(tmp_path):
        assert str(os.getpid()) in (tmp_path / ".lock").read_text()
    assert not list(tmp_path.iterdir())


@pytest.fixture
def busy(tmp_path):
    """A folder with results of a run that another process holds, and the number of that process."""
    for name in ("summary.json", "curve.csv", "pull/summary.json", "load_cases.json", "figures/blocks.png"):
        write_bytes(tmp_path / "run" / name, b'{"load_cases": [{"name": "pull"}]}')
    with subprocess.Popen(
        [sys.executable, "-c", HOLDER, tmp_path / "run"], stdout=subprocess.PIPE, text=True, cwd=PROJECT
    ) as holder:
        assert holder.stdout.readline() == "held\n"
        yield tmp_path / "run", holder.pid
        holder.kill()


LOAD_CASES = ("--set", 'load.cases=[{name="push", direction="+x"}, {name="pull", direction="-x"}]')


@pytest.mark.parametrize(
    "command",
    [
        ("limit", str(TOWER), "--force"),
        ("limit", str(TOWER), "--set", "load.direction=+z", "--force"),
        ("segment", str(TOWER), "--force"),
        ("run", str(TOWER), "--force", "-q"),
        ("run", str(TOWER), *LOAD_CASES, "--force", "-q"),
        ("limit", str(TOWER), *LOAD_CASES, "--force"),
        ("report",),
    ],
)
def test_no_command_writes_into_the_folder_of_a_run_in_progress(busy, capsys, command):
    folder, holder = busy
    before = {path: path.read_bytes() for path in folder.rglob("*") if path.is_file()}
    where = (str(folder),) if command == ("report",) else ("--output", str(folder))
    assert cli.main([*command, *where]) == 2
    (line,) = capsys.readouterr().err.splitlines()
    assert f"{folder}: is in use by process {holder} on " in line
    assert {path: path.read_bytes() for path in folder.rglob("*") if path.is_file()} == before


def test_a_load_case_that_is_being_run_is_not_drawn_over(tmp_path, capsys):
    with locked(tmp_path / "pull"):
        assert cli.main(["limit", str(TOWER), *LOAD_CASES, "--output", str(tmp_path)]) == 2
        assert f"{tmp_path / 'pull'}: is in use by process {os.getpid()} on " in capsys.readouterr().err
    assert not list(tmp_path.iterdir())


def test_a_check_beside_a_run_that_has_just_begun_leaves_its_picture(tmp_path):
    with locked(tmp_path):
        write_bytes(tmp_path / "figures" / "blocks.png", b"of the run")
        assert cli.main(["check", str(TOWER), "--output", str(tmp_path)]) == 0
    assert (tmp_path / "figures" / "blocks.png").read_bytes() == b"of the run"
    assert (tmp_path / "figures" / "checked.png").exists()


def test_a_refused_wall_leaves_no_folder(tmp_path):
    (tmp_path / "wall.json").write_text("{}")
    for command in ("limit", "segment", "run"):
        assert cli.main([command, str(tmp_path / "wall.json"), "--output", str(tmp_path / "a" / "b")]) == 2
        assert [path.name for path in tmp_path.iterdir()] == ["wall.json"]


def test_the_lock_is_free_after_a_failure(tmp_path):
    with pytest.raises(ZeroDivisionError), locked(tmp_path):
        raise ZeroDivisionError
    with locked(tmp_path), pytest.raises(CaseError, match=f"process {os.getpid()} on"), locked(tmp_path):
        pass


def test_sweep_deletes_what_a_killed_run_left_half_written_and_nothing_else(tmp_path):
    folder, elsewhere = tmp_path / "run", tmp_path / "elsewhere"
    for half in (folder / "macro" / "mesh.msh", elsewhere / "curve.csv"):
        leave_half_written(half)
    write_bytes(folder / "macro" / "mesh.msh", b"x")
    mine = (".thesis.tmp", ".curve.csv.12.tmp", "note.tmp", ".a.orchestrator-12345678.tmp/chapter1.txt")
    for name in mine:
        write_bytes(folder / "macro" / name, b"x")
    (folder / "link").symlink_to(elsewhere)
    before = {path for path in tmp_path.rglob("*") if path.is_file()}
    assert len(before) == len(mine) + 3
    sweep(folder, folder / "link", folder / "not there")
    assert {path for path in tmp_path.rglob("*") if path.is_file()} == before
    sweep(folder / "macro")
    (half_written,) = before - {path for path in tmp_path.rglob("*") if path.is_file()}
    assert half_written.name.startswith(".mesh.msh.orchestrator-")


@pytest.mark.parametrize("error", [KeyboardInterrupt, RuntimeError])
def test_a_write_that_ends_half_way_leaves_the_older_file(tmp_path, error):
    path = tmp_path / "summary.json"
    path.write_text("older")

    def write_half():
        with replacing(path) as temporary:
            temporary.write_text("half")
            raise error

    with pytest.raises(error):
        write_half()
    assert [(p.name, p.read_text()) for p in tmp_path.iterdir()] == [("summary.json", "older")]


def test_files_that_belong_together_take_their_places_together(tmp_path):
    first, second = tmp_path / "a" / "first", tmp_path / "b" / "second"
    write_bytes(first, b"older")
    seen = []

    def prepare(files):
        seen.append({path: path.exists() and path.read_bytes() for path in files})
        write_bytes(tmp_path / "now", b"is in its place at once")

    with together(prepare):
        write_bytes(first, b"overwritten")
        with together():
            write_bytes(first, b"newer")
            write_bytes(second, b"new")
        assert first.read_bytes() == b"older"
        assert not second.exists()
        assert read_written(first) == b"newer"
        assert read_written(tmp_path / "a" / "first") == b"newer"
    assert seen == [{first: b"older", second: False}]
    assert first.read_bytes() == read_written(first) == b"newer"
    assert second.read_bytes() == b"new"
    assert sorted(path.name for path in tmp_path.rglob("*")) == ["a", "b", "first", "now", "second"]


@pytest.mark.parametrize("error", [KeyboardInterrupt, RuntimeError, OSError])
def test_of_files_that_belong_together_a_failure_leaves_none(tmp_path, error):
    write_bytes(tmp_path / "first", b"older")
    (tmp_path / "empty").mkdir()

    def write_half():
        with together():
            write_bytes(tmp_path / "first", b"newer")
            write_bytes(tmp_path / "empty" / "second", b"new")
            write_bytes(tmp_path / "made" / "deep" / "third", b"new")
            raise error

    with pytest.raises(error):
        write_half()
    assert (tmp_path / "first").read_bytes() == b"older"
    assert sorted(path.name for path in tmp_path.rglob("*")) == ["empty", "first"]


@pytest.fixture
def interruptible():
    """A shell that has started the tests in the background lets them ignore Ctrl-C."""
    before = signal.signal(signal.SIGINT, signal.default_int_handler)
    yield
    signal.signal(signal.SIGINT, before)


@pytest.mark.usefixtures("interruptible")
def test_ctrl_c_waits_until_all_files_are_in_their_places(tmp_path):
    def prepare(_):
        os.kill(os.getpid(), signal.SIGINT)

    def write():
        with together(prepare):
            write_bytes(tmp_path / "first", b"1")
            write_bytes(tmp_path / "second", b"2")

    with pytest.raises(KeyboardInterrupt):
        write()
    assert [(tmp_path / name).read_bytes() for name in ("first", "second")] == [b"1", b"2"]
    assert signal.getsignal(signal.SIGINT) is signal.default_int_handler


def test_every_changed_bit_and_every_cut_breaks_the_seal():
    content = sealed(b"stone by stone")
    assert unsealed(content) == b"stone by stone"
    for bit in range(8 * len(content)):
        flipped = bytearray(content)
        flipped[bit // 8] ^= 1 << bit % 8
        with pytest.raises(ValueError, match="sha256"):
            unsealed(bytes(flipped))
    for length in range(len(content)):
        with pytest.raises(ValueError, match="sha256"):
            unsealed(content[:length])
