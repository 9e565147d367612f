"""A result that breaks a law of mechanics says so wherever it is read: table, picture, summary.json, exit code 3."""

from __future__ import annotations

import json
from dataclasses import replace

import numpy as np
import pytest
from matplotlib.text import Text

from orchestrator.app import cli
from orchestrator.basis.errors import ResultError
from orchestrator.present import plots
from orchestrator.pushover.increments import PushoverCurve
from orchestrator.pushover.path import increment_solver
from orchestrator.pushover.path.body_overlap import Misfit
from orchestrator.pushover.path.curve_checks import RowMisfits, check_curve
from orchestrator.pushover.path.increment_record import increment_of
from tests.support.paths import DATA

TOWER = DATA / "tower_5_blocks.json"


def curve(**changed):
    """A curve of a wall of 1000 N that breaks no law."""
    rows = np.arange(4)
    shear, zero = np.array([0.0, 100.0, 200.0, 150.0]), np.zeros(4)
    whole = PushoverCurve(
        rows,
        zero,
        shear / 1000,
        shear,
        zero + 1000,
        1e-3 * rows,
        zero + 1,
        zero,
        *4 * [rows],
        zero,
        0 * rows,
        0 * rows,
        "",
    )
    return replace(whole, **changed)


def misfits(overlap=0.0, pressed_gap=0.0):
    """A row at 2 mm in which two stones overlap and press each other from afar by such shares of their size."""
    where = (("block 1", "block 2"), (0.25, 1.5))
    return RowMisfits(2, 2e-3, Misfit(0.3 * overlap, overlap, *where), Misfit(0.3 * pressed_gap, pressed_gap, *where))


WRONG = {
    "equilibrium": (
        {"load_multiplier": np.array([0.0, 0.1, 0.203, 0.15])},
        None,
        0.0,
        200.0,
        r"1.50e-02 \(at most 0.001\) of the peak",
    ),
    "penetration": (
        {},
        misfits(overlap=6e-3),
        0.0,
        200.0,
        r"6.00e-03 \(at most 0.005\) of the smaller body's size is the depth to which block 1 and block 2 overlap at "
        r"\(0.25, 1.5\) m, from 2 mm on",
    ),
    "touch": (
        {},
        misfits(pressed_gap=6e-3),
        0.0,
        200.0,
        r"6.00e-03 \(at most 0.005\) of the smaller body's size is the gap across which block 1 and block 2 press each "
        r"other at \(0.25, 1.5\) m, from 2 mm on",
    ),
    "energy balance": ({}, None, 0.02, 200.0, r"2.00e-02 \(at most 0.01\) of stored energy"),
    "static theorem": (
        {},
        None,
        0.0,
        198.0,
        r"1.01e-02 \(at most 0.005\) is what the peak is above the associative",
    ),
}


def test_a_good_curve_passes():
    check_curve(curve(), misfits(1e-12, 1e-12), 1e-6, 200.0)
    check_curve(curve(), None, 1e-6, None)


def test_a_row_in_motion_may_be_out_of_balance_and_above_what_a_static_state_carries():
    multiplier = np.array([0.0, 0.1, 0.25, 0.15])
    check_curve(curve(load_multiplier=multiplier, moving=np.array([0, 0, 1, 0])), None, 0.0, 150.0)


@pytest.mark.parametrize("name", WRONG)
def test_every_bound_is_guarded_and_named(name):
    changed, found, energy, highest, said = WRONG[name]
    with pytest.raises(ResultError, match=said) as caught:
        check_curve(curve(**changed), found, energy, highest)
    assert caught.value.check == name


def test_all_failures_are_named():
    with pytest.raises(
        ResultError, match=r"penetration: 1\.00e\+00 .*and touch: 1\.00e\+00 .*and energy balance: 5\.00e-01"
    ):
        check_curve(curve(), misfits(1.0, 1.0), 0.5, 200.0)


@pytest.mark.parametrize("name", ["load_multiplier", "base_shear_N"])
def test_what_is_not_a_number_is_not_valid(name):
    values = getattr(curve(), name).copy()
    values[1] = np.nan
    with pytest.raises(ResultError):
        check_curve(curve(**{name: values}), None, 0.0, 200.0)
    for found in ((misfits(np.nan, 0.0), 0.0), (misfits(0.0, np.nan), 0.0), (None, np.nan)):
        with pytest.raises(ResultError):
            check_curve(curve(), *found, 200.0)


def leaky(*arguments):
    """Bookkeeping that loses a fifth of the work of the loads."""
    made, before = increment_of(*arguments), arguments[1]
    lost = 0.2 * (made.external_work - before.external_work)
    return replace(made, energy_error=made.energy_error - lost)


def nameless(*arguments):
    """Bookkeeping that divides nothing by nothing once."""
    made = increment_of(*arguments)
    return replace(made, energy_error=np.nan) if made.number == 9 else made


@pytest.mark.parametrize("wrong", [leaky, nameless])
def test_a_run_whose_energy_is_lost_says_so_everywhere(wrong, tmp_path, monkeypatch, capsys):
    drawn = []
    monkeypatch.setattr(increment_solver, "increment_of", wrong)
    monkeypatch.setattr(plots, "curves", lambda *given, draw=plots.curves: drawn.append(draw(*given)) or drawn[0])
    command = ["run", str(TOWER), "--model", "micro", "--set", "stepping.final_displacement=1mm"]
    assert cli.main([*command, "--output", str(tmp_path)]) == 3
    printed = capsys.readouterr()
    assert "micro-FE, NOT VALID" in printed.out
    assert "NOT VALID: micro FE: energy balance" in printed.out
    assert printed.err.count("result not valid: micro FE: energy balance") == 1
    (pushover,) = json.loads((tmp_path / "summary.json").read_text())["pushover"]
    assert pushover["valid"] is False
    assert pushover["not_valid_because"].startswith("energy balance")
    axes = drawn[0].axes[0]
    assert "NOT VALID: micro FE: energy balance" in axes.get_title().replace("\n", " ")
    assert "NOT VALID" in [text.get_text() for text in axes.texts]


def test_every_picture_of_what_is_not_valid_is_stamped(tmp_path, monkeypatch):
    """Deformed walls, bilinear curve; a study's sheet, mechanisms and curves. What no increment enters is not."""
    saved = {}
    monkeypatch.setattr(increment_solver, "increment_of", leaky)
    monkeypatch.setattr(plots, "save", lambda figure, folder, name, *_: saved.update({name: figure}) or [folder / name])
    short = ["--set", "stepping.final_displacement=1mm", "--output"]
    assert cli.main(["run", str(TOWER), "--model", "micro", *short, str(tmp_path / "run")]) == 3
    grid = ["--set", "study.tol_n=['none']", "--set", "study.tol_d=['none']"]
    monkeypatch.setattr(plots, "save", lambda figure, folder, name, *_: saved.update({f"{folder.name} {name}": figure}))
    assert cli.main(["study", str(TOWER), *grid, *short, str(tmp_path / "study")]) == 3
    stamped = {name for name, figure in saved.items() if "NOT VALID" in [t.get_text() for t in figure.findobj(Text)]}
    drawn_before = {"blocks", "mechanism", "macroblocks", "rigid_pushover"}
    assert {name.split()[-1] for name in stamped} == {name.split()[-1] for name in saved} - drawn_before
    assert {"curves", "micro_end", "micro_peak", "figures table", "figures mechanisms", "figures curves"} <= stamped


def test_a_valid_run_is_marked_nowhere(tmp_path, capsys):
    command = ["run", str(TOWER), "--model", "micro", "--set", "stepping.final_displacement=1mm"]
    assert cli.main([*command, "--output", str(tmp_path)]) == 0
    assert "NOT VALID" not in capsys.readouterr().out
    assert "NOT VALID" not in (tmp_path / "figures" / "curves.svg").read_text()
    (pushover,) = json.loads((tmp_path / "summary.json").read_text())["pushover"]
    assert (pushover["valid"], pushover["not_valid_because"]) == (True, None)
