"""A curve ends where stones begin to overlap, if its peak is behind by then; else it is not valid."""

from __future__ import annotations

import json
import re
from dataclasses import replace

import numpy as np
import pytest

from orchestrator import (
    LoadSettings,
    MeshSettings,
    SteppingSettings,
    analyse,
    find_joints,
    loads_on,
    one_body_per_block,
    push,
    storage,
)
from orchestrator.app import cli
from orchestrator.app.curve_end import balanced, first_misfit, is_cut_short, usable, used
from orchestrator.loads import DeadLoad
from orchestrator.masonry.joints import JointClass, JointSettings
from orchestrator.masonry.patterns import Arch, arch_on_piers
from orchestrator.masonry.wall import Block, Wall
from orchestrator.pushover.increments import PushoverCurve
from orchestrator.pushover.path.body_overlap import DisplacedOutlines, Misfit
from orchestrator.pushover.path.curve_checks import RowMisfits
from tests.support.paths import DATA
from tests.support.pushover_chain import rectangle
from tests.support.walls import of_file

TOWER = DATA / "tower_5_blocks.json"
"""overturns at 1.6 mm and 3.2 kN; its base shear has fallen by 1 % at 5.6 mm"""
WIDE, HIGH = 0.5, 2.0
"""of a block on mortar, m"""
WHERE = (("block 1", "block 2"), (0.25, 1.5))


def curve_of(*shear, moving=None):
    """A curve of a wall of 1000 N that moves by 1 mm a row."""
    rows, zero = np.arange(len(shear)), np.zeros(len(shear))
    still = 0 * rows if moving is None else np.array(moving)
    shear = np.array(shear)
    return PushoverCurve(
        rows, zero, shear / 1000, shear, zero + 1000, 1e-3 * rows, zero + 1, zero, *4 * [rows], zero, still, 0 * rows,
        "final displacement reached",
    )  # fmt: skip


def rows_of(*shares, gap=False):
    """Rows whose stones overlap (press each other from afar) by such shares of their size."""
    both = [(Misfit(), Misfit(0.1 * share, share, *WHERE))[:: 1 if gap else -1] for share in shares]
    return [RowMisfits(number, 1e-3 * number, *pair) for number, pair in enumerate(both)]


@pytest.mark.parametrize("direction", ["+x", "-x"])
def test_the_end_counts_from_where_gravity_has_left_the_top(direction):
    """A load beside the middle of a block on mortar leans it by 12 F e h / (k t b^3): more than the end."""
    mortar = JointClass(normal_stiffness=1e8, shear_stiffness=4e7)
    block = Block(1, rectangle(0.0, 0.0, WIDE, HIGH), False, 20e3)
    wall = Wall("block", (Block(0, rectangle(-1.0, -0.2, 3.0, 0.2), True, 20e3), block), 1.0, 0.7)
    assemblage = find_joints(wall, JointSettings(classes=(mortar,)))
    load = LoadSettings(direction, dead=(DeadLoad((1,), force=6e3, at=(0.75 * WIDE, HIGH)),))
    analysis = analyse(assemblage, loads=loads_on(wall, load))
    stepping = SteppingSettings(final_displacement=1e-3)
    every_stone, mesh = one_body_per_block(assemblage), MeshSettings(size=0.1)
    curve = push(assemblage, analysis, every_stone, load, mesh=mesh, stepping=stepping).curve
    moved, leans = curve.control_displacement_m, 12 * 6e3 * 0.25 * WIDE * HIGH / (1e8 * WIDE**3)
    assert abs(moved[0]) == pytest.approx(leans, rel=0.1)
    assert leans > 1e-3
    assert moved[-2] - moved[0] < 1e-3 <= 1.001 * (moved[-1] - moved[0]) < 1.02e-3


def test_a_curve_whose_stones_fit_is_as_it_was():
    curve = curve_of(0.0, 100.0, 90.0)
    assert usable(curve, rows_of(0.0, 4.9e-3, 5e-3)) is curve
    assert usable(curve, []) is curve


@pytest.mark.parametrize("gap", [False, True])
def test_stones_that_overlap_once_the_load_has_fallen_end_the_curve(gap):
    rows = rows_of(0.0, 1e-3, 4e-3, 6e-3, 1e-3, gap=gap)
    curve = curve_of(0.0, 100.0, 98.9, 98.0, 97.0)
    ends = usable(curve, rows)
    assert not is_cut_short(curve, ends)
    assert ends.step.tolist() == [0, 1, 2]
    what = "press each other across a gap" if gap else "overlap"
    assert ends.stopped_because == (
        f"the curve ends before 3 mm: from there on block 1 and block 2 {what} at (0.25, 1.5) m, 6.00e-03 of the "
        "smaller one's size (at most 0.005)"
    )
    assert first_misfit(used(rows, ends)) is None


@pytest.mark.parametrize(
    "shear",
    [(0.0, 100.0, 99.1, 80.0), (0.0, 100.0, 100.0, 100.0), (0.0, 50.0, 100.0, 90.0)],
    ids=["it has not fallen by 1 %", "a plateau", "it rises"],
)
def test_what_stones_bear_before_they_overlap_is_the_least_that_they_bear(shear):
    """What they go through might have held them: also on a plateau nothing says that more is not to come."""
    curve = curve_of(*shear)
    ends = usable(curve, rows_of(0.0, 1e-3, 1e-3, 6e-3))
    assert ends.step.tolist() == [0, 1, 2]
    assert is_cut_short(curve, ends)


def test_stones_that_overlap_before_any_live_load_leave_a_curve_not_valid():
    curve, rows = curve_of(0.0, 100.0, 90.0), rows_of(0.0, 6e-3, 6e-3)
    assert usable(curve, rows) is curve
    found = first_misfit(used(rows, curve))
    assert found is not None
    assert found.number == 1


def test_a_load_that_falls_in_motion_has_not_fallen():
    curve = curve_of(0.0, 100.0, 90.0, 99.5, 80.0, moving=[0, 0, 1, 0, 0])
    ends = usable(curve, [row for row in rows_of(0.0, 0.0, 0.0, 0.0, 6e-3) if row.number != 2])
    assert ends.step.tolist() == [0, 1, 2, 3]
    assert is_cut_short(curve, ends)


def test_no_number_is_no_fit():
    curve = curve_of(0.0, 100.0, 90.0, 80.0)
    assert usable(curve, rows_of(0.0, 0.0, 0.0, np.nan)).step.tolist() == [0, 1, 2]


def overlapping_from(far):
    """Overlaps that are found from a displacement of the tower's top on, m."""

    def found(outlines, displacement, fallen, closed=0.0):
        nodes = outlines.meshes.nodes
        beyond = displacement[: len(nodes)][nodes[:, 1].argmax(), 0] > far
        return Misfit(2e-3, 6e-3, *WHERE) if beyond else Misfit()

    return found


def pushed(folder, *more):
    command = ["run", str(TOWER), "--model", "micro", "--set", "stepping.final_displacement=10mm"]
    return cli.main([*command, "--output", str(folder), *more])


def test_a_run_that_ends_before_its_last_increment_says_the_same_everywhere(tmp_path, monkeypatch, capsys):
    monkeypatch.setattr(DisplacedOutlines, "largest_overlap", overlapping_from(7e-3))
    assert pushed(tmp_path) == 0
    said = "from there on block 1 and block 2 overlap at (0.25, 1.5) m"
    printed = capsys.readouterr()
    assert said in printed.err + printed.out
    assert "NOT VALID" not in printed.out
    assert "3.199 kN counts" in printed.out
    (summary,) = json.loads((tmp_path / "summary.json").read_text())["pushover"]
    assert summary["valid"]
    assert summary["peak_reached"]
    assert said in summary["stopped_because"]
    assert summary["max_penetration_over_size"] == 0.0
    curve = storage.read_curve(tmp_path / "micro", "")
    assert 5e-3 < curve.control_displacement_m[-1] < 7e-3
    assert summary["final_displacement"] == curve.control_displacement_m[-1] - curve.control_displacement_m[0]
    assert summary["steps"] == curve.step[-1]
    page = (tmp_path / "report.html").read_text()
    assert said in page
    assert "NOT VALID" not in page
    before = (tmp_path / "micro" / "curve.csv").read_bytes()
    assert pushed(tmp_path, "--resume") == 0
    assert (tmp_path / "micro" / "curve.csv").read_bytes() == before


def test_a_run_whose_stones_overlap_before_its_peak_bears_at_least_what_it_bore(tmp_path, monkeypatch, capsys):
    """The tower rocks from 0.05 mm on: on its plateau, which falls by less than 1 % in 1 mm."""
    monkeypatch.setattr(DisplacedOutlines, "largest_overlap", overlapping_from(1e-3))
    assert pushed(tmp_path) == 0
    said = "from there on block 1 and block 2 overlap at (0.25, 1.5) m"
    printed = " ".join(capsys.readouterr().out.split())
    assert "≥ 3." in printed
    (summary,) = json.loads((tmp_path / "summary.json").read_text())["pushover"]
    assert summary["valid"]
    assert not summary["peak_reached"]
    assert said in summary["stopped_because"]
    assert 0.0 < summary["final_displacement"] < 1e-3


def test_a_jump_past_the_peak_ends_the_curve_and_the_peak_counts():
    """The tower, as if its last increment had missed 5 J."""
    tower, told = of_file("tower_5_blocks"), []
    stepping = SteppingSettings(final_displacement=0.01)
    done = push(tower, analyse(tower), one_body_per_block(tower), stepping=stepping, report=told.append)
    *path, last = [one.increment for one in told]
    assert balanced(done.curve, [*path, last]) is done.curve
    ends = balanced(done.curve, [*path, replace(last, energy_error=5.0)])
    assert ends.step[-1] == path[-1].number
    assert ends.base_shear_N.max() == done.curve.base_shear_N.max()
    assert re.match(r"the curve ends at 8\.\d+ mm: on the way to 10 mm .* \(at most 0\.01\)", ends.stopped_because)


def test_a_flat_arch_bears_the_same_in_large_and_in_small_displacements():
    """22 stones on piers: past its peak it jumps to another path of equilibrium, where the load is 14 % less. In small
    displacements it bears 0.2333 and does not jump."""
    arch = of_file("jack_arch_on_piers_22_stones")
    analysis, stones = analyse(arch), one_body_per_block(arch)
    mesh = MeshSettings(toe_offset=0.5)  # edges that give way take from large displacements only
    large = push(arch, analysis, stones, mesh=mesh, stepping=SteppingSettings(final_drop=0.02))
    small = push(
        arch, analysis, stones, mesh=mesh, stepping=SteppingSettings(large_displacement=False, final_drop=0.02)
    )
    assert large.summary.valid
    assert small.summary.valid
    assert large.capacity.peak_multiplier == pytest.approx(small.capacity.peak_multiplier, rel=5e-3)


def test_increments_do_not_shrink_to_where_rounding_bends_them():
    """Past its peak this arch stood still for 2,000 increments down to 1e-16 m, each bent and out of balance."""
    assemblage = find_joints(arch_on_piers(Arch(24, 5.0, 0.6, friction=0.8)), JointSettings())
    stones = one_body_per_block(assemblage)
    done = push(assemblage, analyse(assemblage), stones, mesh=MeshSettings(0.06))
    assert done.summary.stopped_because == "base shear 20 % below its peak"
    assert done.summary.steps < 100
