"""Ctrl-C at any moment: exit code 130, one line, and no word that is wrong."""

from __future__ import annotations

import signal
import subprocess
import sys

import pytest

from orchestrator.app import cli, load_case_runs
from orchestrator.present import report as reporting
from tests.support.paths import DATA, PROJECT

TOWER = str(DATA / "tower_5_blocks.json")
PUSH_AND_PULL = ("--set", 'load.cases=[{name="push", direction="+x"}, {name="pull", direction="-x"}]')
INTERRUPTED = """
import os, runpy, signal, sys
module = sys.argv.pop(1)
def hook(event, arguments):
    global module
    if event == "import" and arguments[0] == module:
        module = ""
        os.kill(os.getpid(), signal.SIGINT)
sys.addaudithook(hook)
runpy.run_module("orchestrator", run_name="__main__", alter_sys=True)
"""
"""Is interrupted when it is about to import a module."""


def interrupted_at(module, *command, ignoring=False):
    """Run a command that is interrupted when it imports a module; return exit code, standard output and error."""
    done = subprocess.run(
        [sys.executable, "-c", INTERRUPTED, module, *command], capture_output=True, text=True, cwd=PROJECT,
        timeout=120, preexec_fn=lambda: signal.signal(signal.SIGINT, signal.SIG_IGN if ignoring else signal.SIG_DFL),
    )  # fmt: skip
    return done.returncode, done.stdout, done.stderr


@pytest.mark.parametrize(
    "module", ["orchestrator.app.cli", "rich.console", "orchestrator.app.commands", "pydantic", "numpy", "scipy.sparse"]
)
def test_ctrl_c_while_the_program_starts_is_one_line(tmp_path, module):
    """An ImportError of the library that is interrupted, or an exception that it swallows, would be something else."""
    found = interrupted_at(module, "limit", TOWER, "--output", str(tmp_path / "out"))
    assert found == (130, "", "interrupted\n")
    assert list(tmp_path.iterdir()) == []


@pytest.mark.parametrize("module", ["mpi4py", "orchestrator.app.driver"])
def test_ctrl_c_while_a_run_starts_is_one_line(tmp_path, module):
    assert interrupted_at(module, "run", TOWER, "--output", str(tmp_path / "out")) == (130, "", "interrupted\n")
    assert list(tmp_path.iterdir()) == []


def test_who_starts_it_to_go_on_after_ctrl_c_is_heeded(tmp_path):
    code, _, error = interrupted_at("numpy", "check", TOWER, "--output", str(tmp_path / "out"), ignoring=True)
    assert (code, error) == (0, "")


def interruption(*_, **__):
    raise KeyboardInterrupt


@pytest.mark.parametrize("settings", [(), PUSH_AND_PULL])
@pytest.mark.parametrize("option", ["--force", "--resume", None])
def test_what_is_said_of_an_interruption_is_so(tmp_path, monkeypatch, capsys, settings, option):
    """Before the earlier results are removed there is nothing to go on with; afterwards there is."""
    folder = tmp_path / "run"
    if option:
        (folder / "macro").mkdir(parents=True)
    command = ["run", TOWER, "-q", *settings, *([option] if option else []), "--output", str(folder)]
    goes_on = "interrupted; go on with --resume\n"
    early = ("segment" if not settings else "refuse_what_does_not_stand", interruption)
    with monkeypatch.context() as patched:
        patched.setattr(load_case_runs.driver, *early)
        assert cli.main(command) == 130
    assert (folder / "macro").exists() == bool(option)
    assert capsys.readouterr().err == (goes_on if option == "--resume" else "interrupted before anything was written\n")
    with monkeypatch.context() as patched:
        patched.setattr(reporting, "write_segmentation", interruption)
        assert cli.main(command) == 130
    assert capsys.readouterr().err == goes_on
