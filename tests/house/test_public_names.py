"""`from orchestrator import ...`: every name is there, and none costs more than it needs."""

from __future__ import annotations

import ast
import re
import subprocess
import sys
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

import orchestrator
from orchestrator import (  # fmt: skip
    CaseError,
    DeadLoad,
    JointSettings,
    LoadSettings,
    MacroblockSettings,
    MeshSettings,
    SteppingSettings,
    analyse,
    check_assemblage,
    check_wall,
    find_joints,
    loads_on,
    macroblocks_of,
    make_bodies,
    merged,
    one_body_per_block,
    plot_curves,
    plot_macroblocks,
    push,
    read_blocks,
    read_case,
    read_run,
)
from orchestrator.app.cli import main
from orchestrator.app.driver import run, segment
from tests.support.paths import DATA
from tests.support.pushover_chain import assemblage_of, stack
from tests.support.ranks import quiet

TOWER = DATA / "tower_5_blocks.json"

HEAVY = (
    "numpy", "scipy", "scipy.optimize", "scipy.spatial", "scipy.stats", "shapely", "clarabel", "dolfinx", "gmsh",
    "petsc4py", "mpi4py", "pydantic", "rich", "rich.progress", "h5py", "matplotlib", "ezdxf", "skimage",
)  # fmt: skip
"""modules that take longer than Python's own start, or that not every machine has"""


def imported_by(statement):
    """Return which of the heavy modules a fresh interpreter has after a statement."""
    program = f"{statement}\nimport sys\nprint(*[name for name in {HEAVY} if name in sys.modules])"
    done = subprocess.run([sys.executable, "-c", program], capture_output=True, text=True, check=True)
    return done.stdout.split()


def test_nothing_but_public_names_is_listed():
    assert [name for name in dir(orchestrator) if not name.startswith("_")] == orchestrator.__all__


@pytest.mark.parametrize("name", orchestrator.__all__)
def test_every_public_name_is_there_and_has_a_docstring(name):
    assert getattr(orchestrator, name).__doc__
    assert name in dir(orchestrator)


def test_type_checkers_see_every_public_name_where_it_is():
    """A stub beside the lazy imports: without it a user's type checker takes every name for Any."""
    found = set()
    for node in ast.parse(Path(orchestrator.__file__).with_suffix(".pyi").read_text()).body:
        if isinstance(node, ast.ImportFrom):
            found |= {(node.module, one.name, one.asname or one.name) for one in node.names}
    renamed = orchestrator.RENAMED
    expected = {
        (f"orchestrator.{module}", renamed.get(name, name), name)
        for module, names in orchestrator.PUBLIC.items()
        for name in names
    }
    assert found == expected


def test_an_unknown_name_is_an_attribute_error():
    with pytest.raises(AttributeError, match="no attribute 'pushover_kurve'"):
        _ = orchestrator.pushover_kurve


def test_importing_the_package_imports_nothing_else():
    assert imported_by("import orchestrator") == []


def imported_by_command(*words):
    """Return which of the heavy modules a command has imported when it ends, and its exit code."""
    program = (
        "import contextlib, io, sys\nfrom orchestrator.app.cli import main\n"
        "with contextlib.redirect_stdout(io.StringIO()), contextlib.redirect_stderr(io.StringIO()):\n"
        f"    try:\n        code = main({list(words)})\n    except SystemExit as left:\n        code = left.code\n"
        f"print(code, *[name for name in {HEAVY} if name in sys.modules])"
    )
    done = subprocess.run([sys.executable, "-c", program], capture_output=True, text=True, check=True)
    code, *names = done.stdout.split()
    return names, int(code)


COMMANDS = ("run", "check", "limit", "segment", "study", "sensitivity", "import", "new", "schema", "export", "report")


def test_the_commands_are_all_the_commands(capsys):
    with pytest.raises(SystemExit):
        main(["--help"])
    listed = re.findall(r"^    (\w+) ", capsys.readouterr().out, re.M)
    assert sorted(listed) == sorted(COMMANDS)


@pytest.mark.parametrize("words", [["--help"], ["--version"], *([command, "--help"] for command in COMMANDS)], ids=str)
def test_help_imports_nothing_that_takes_time(words):
    assert imported_by_command(*words) == ([], 0)


@pytest.mark.parametrize("words", [["run"], ["limit", "case.toml", "--sett", "x"], ["walk"]], ids=str)
def test_misspelt_options_import_nothing_that_takes_time(words):
    assert imported_by_command(*words) == ([], 2)


ANALYSES_OR_DRAWS = {*HEAVY} - {"numpy", "scipy", "shapely", "clarabel", "pydantic", "rich"}


@pytest.mark.parametrize("command", ["check", "limit", "segment", "export"])
@pytest.mark.parametrize("case", ["no.toml", str(TOWER)])
def test_a_case_is_refused_before_what_works_with_it_is_imported(command, case):
    """A file that is not there, a key that is not known."""
    names, code = imported_by_command(command, case, "--set", "mesh.sise=100mm")
    assert code == 2
    assert "pydantic" in names, "the detector sees what checks a case"
    assert not ANALYSES_OR_DRAWS & {*names}


def test_no_finite_elements_before_the_pushover():
    names = "analyse, find_joints, make_bodies, merged, read_blocks, macroblocks_of"
    assert not {"dolfinx", "gmsh", "petsc4py", "mpi4py"} & set(imported_by(f"from orchestrator import {names}"))


WIDTH, HEIGHT, WEIGHT, FLOOR = 0.2, 1.0, 500.0, 250.0
"""a block of 25 kN/m3, 0.1 m thick, in m and N; the floor it may carry"""


def rocking(load):
    """Push the block under a load until its top has moved by 2 mm; return it and its limit analysis."""
    assemblage = assemblage_of(stack((WIDTH, HEIGHT), friction=0.7))
    analysis = analyse(assemblage, loads=loads_on(assemblage.wall, load))
    settings = {"mesh": MeshSettings(size=0.1), "stepping": SteppingSettings(final_displacement=2e-3)}
    return push(assemblage, analysis, one_body_per_block(assemblage), load, **settings), analysis


@pytest.mark.parametrize("direction", ["+x", "-x"])
@pytest.mark.parametrize("floor", [0.0, FLOOR])
def test_a_slender_block_rocks_about_its_corner(direction, floor):
    """(W + F) b / 2 = lambda (W h / 2 + F h), less u / h and elasticity: no static state exceeds it."""
    dead = (DeadLoad((1,), line_load=floor / WIDTH, inertia=True),) if floor else ()
    pushed, _ = rocking(LoadSettings(direction=direction, dead=dead))
    exact = (WEIGHT + floor) * WIDTH / 2 / (WEIGHT * HEIGHT / 2 + floor * HEIGHT)
    assert pushed.capacity.peak_multiplier == pytest.approx(exact, rel=0.01)
    assert pushed.capacity.peak_multiplier <= exact * (1 + SteppingSettings().out_of_balance)
    assert pushed.capacity.peak_base_shear == pytest.approx(exact * (WEIGHT + floor), rel=0.01)
    assert pushed.curve.stopped_because == "final displacement of 2 mm reached"
    assert np.all(np.diff(pushed.curve.step) == 1)
    assert pushed.summary.valid
    assert not pushed.complaints


def test_push_refuses_a_limit_analysis_under_another_load():
    assemblage = assemblage_of(stack((WIDTH, HEIGHT), friction=0.7))
    every_block, analysis = one_body_per_block(assemblage), analyse(assemblage)
    floor = LoadSettings(dead=(DeadLoad((1,), force=FLOOR, inertia=True),))
    standing = replace(floor, dead=(replace(floor.dead[0], inertia=False),))
    for load in (LoadSettings(direction="-x"), floor, standing):
        with pytest.raises(CaseError, match="load: is not the load of this limit analysis"):
            push(assemblage, analysis, every_block, load)
    middle, edge = (LoadSettings(dead=(DeadLoad((1,), force=FLOOR, at=(x, HEIGHT)),)) for x in (0.0, WIDTH / 4))
    with pytest.raises(CaseError, match="load: is not the load of this limit analysis"):
        push(assemblage, analyse(assemblage, loads=loads_on(assemblage.wall, middle)), every_block, edge)
    top, foot = (LoadSettings(dead=(DeadLoad((1,), force=FLOOR, at=(0.0, y)),)) for y in (HEIGHT, 0.0))
    with pytest.raises(CaseError, match="load: is not the load of this limit analysis"):
        push(assemblage, analyse(assemblage, loads=loads_on(assemblage.wall, top)), every_block, foot)


SLENDER = assemblage_of(stack((WIDTH, HEIGHT), friction=0.7))
OTHERS = {
    "wider": assemblage_of(stack((2 * WIDTH, HEIGHT), friction=0.7)),
    "higher": assemblage_of(stack((WIDTH, HEIGHT), (WIDTH, HEIGHT), friction=0.7)),
    "rougher": assemblage_of(stack((WIDTH, HEIGHT), friction=0.8)),
}


@pytest.mark.parametrize("other", ["wider", "higher"])
def test_loads_of_another_wall_are_refused(other):
    with pytest.raises(CaseError, match=r"loads: are not those of this wall.*loads_on\(assemblage.wall"):
        analyse(SLENDER, loads=loads_on(OTHERS[other].wall))


def test_loads_that_are_no_numbers_are_refused():
    loads = loads_on(SLENDER.wall)
    with pytest.raises(CaseError, match="loads: are not finite"):
        analyse(SLENDER, loads=replace(loads, live=np.nan * loads.live))


@pytest.mark.parametrize("other", OTHERS)
def test_an_analysis_of_another_wall_is_refused(other):
    analysis = analyse(SLENDER)
    with pytest.raises(CaseError, match="analysis: is not of this wall"):
        push(OTHERS[other], analysis, one_body_per_block(OTHERS[other]))
    with pytest.raises(CaseError, match="analysis: is not of this wall"):
        macroblocks_of(OTHERS[other], analysis)


@pytest.mark.parametrize("other", ["wider", "higher"])
def test_a_partition_of_another_wall_is_refused(other):
    for use in (plot_macroblocks, make_bodies, lambda wall, bodies: push(wall, analyse(wall), bodies)):
        with pytest.raises(CaseError, match="partition: is not of this wall"):
            use(OTHERS[other], one_body_per_block(SLENDER))


def test_push_says_which_loads_it_takes():
    with pytest.raises(CaseError, match="load: Loads was given, LoadSettings is expected"):
        push(SLENDER, analyse(SLENDER), one_body_per_block(SLENDER), loads_on(SLENDER.wall))


def test_a_mechanism_of_another_wall_is_refused():
    with pytest.raises(CaseError, match="mechanism: has 2 blocks and 1 joints, the wall 3 and 2; give a mechanism of"):
        merged(OTHERS["higher"], analyse(SLENDER).headline.mechanism, MacroblockSettings())


def test_loads_and_partitions_outlive_a_change_of_friction():
    rough = OTHERS["rougher"]
    assert analyse(rough, loads=loads_on(SLENDER.wall)).weight == analyse(rough).weight
    assert make_bodies(rough, one_body_per_block(SLENDER)).moving == 1


def test_push_follows_the_curve_that_run_stores_and_read_run_reads(tmp_path):
    case = read_case(DATA / "tower_5_blocks.json", ["stepping.final_displacement=0.5mm", "run.models=['macro']"])
    run(case, tmp_path, False, None, quiet)
    stored = read_run(str(tmp_path))
    found, told = segment(case), []
    settings = {name: getattr(case, name) for name in ("mesh", "elastic", "contact", "newton", "stepping")}
    pushed = push(found.assemblage, found.analysis, found.partition, case.load, report=told.append, **settings)
    (model,) = stored.models
    assert model.curve.base_shear_N.tobytes() == pushed.curve.base_shear_N.tobytes()
    assert model.curve.control_displacement_m.tobytes() == pushed.curve.control_displacement_m.tobytes()
    assert len(told) == pushed.summary.steps == stored.summary.pushover[0].steps
    assert told[-1].fraction == pytest.approx(1.0, rel=1e-3)
    shear = f"{1e-3 * pushed.curve.base_shear_N[-1]:.3f} kN"
    said = rf"macro FE: increment {len(told)} displacement: 0\.50 mm, {shear} \(λ \d\.\d{{4}}\), \d+ iterations?"
    assert re.fullmatch(said, str(told[-1])), str(told[-1])
    assert re.fullmatch(
        r"macro FE: increment 1 gravity: 0\.00 mm, 0\.000 kN \(λ 0\.0000\), \d+ iterations?", str(told[0])
    )
    figure = plot_curves({"macroblocks": (model.curve, pushed.capacity)}, stored.analysis, "tower")
    said = [line.get_label() for line in figure.axes[0].lines]
    assert any(f"λ = {pushed.capacity.peak_multiplier:.4f}" in text for text in said)
    assert plot_macroblocks(stored.assemblage, stored.partition).axes


def test_arguments_of_another_kind_are_told_in_one_line():
    """Not by an AttributeError of whatever they lack."""
    assemblage = find_joints(read_blocks(TOWER), JointSettings())
    wall, settings = assemblage.wall, JointSettings()
    analysis, stones = analyse(assemblage), one_body_per_block(assemblage)
    told = {
        "wall: Assemblage was given, Wall is expected; ": lambda: find_joints(assemblage, settings),
        "wall: NoneType was given, Wall is expected; ": lambda: find_joints(None, settings),
        "settings: dict was given, JointSettings is expected; ": lambda: find_joints(wall, {}),
        "wall: str was given, Wall is expected; ": lambda: check_wall("wall.json"),
        "assemblage: Wall was given, Assemblage is expected; ": lambda: check_assemblage(wall),
        "wall: Assemblage was given, Wall is expected; write loads_on": lambda: loads_on(assemblage),
        "settings: str was given, LoadSettings is expected; ": lambda: loads_on(wall, "+x"),
        "assemblage: str was given, Assemblage is expected; ": lambda: push("a", "b", "c"),
        "analysis: Partition was given, LimitAnalysis is expected; ": lambda: push(assemblage, stones, analysis),
        "assemblage: LimitAnalysis was given, Assemblage is expected; ": lambda: macroblocks_of(analysis, assemblage),
        "partition: NoneType was given, Partition is expected; ": lambda: push(assemblage, analysis, None),
    }
    for said, call in told.items():
        with pytest.raises(CaseError, match=re.escape(said)) as caught:
            call()
        assert "\n" not in str(caught.value)
