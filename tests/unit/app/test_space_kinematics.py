"""The kinematic verification of a wall in space: of the lowest state found, and of all that has mass."""

from __future__ import annotations

import json
import re
from dataclasses import replace
from itertools import pairwise

import numpy as np
import pytest

from orchestrator.app import cli
from orchestrator.assessment.seismic.in_space import StartsAt, starts_at
from orchestrator.assessment.seismic.local_mechanism import UPPER_BOUND
from orchestrator.geometry.polyhedra import Polyhedron, box
from orchestrator.masonry.wall import GRAVITY
from orchestrator.space.analysis import SpaceLimitSettings, analyse
from orchestrator.space.contacts import find_joints
from orchestrator.space.generators.shapes import Plan, Stones, l_wall
from orchestrator.space.loads import SpaceLoadSettings, loads_on
from tests.support.space_walls import CUBE, GROUND, block_file_of, wall_of


def kinematic_line(tmp_path, capsys, shapes, *loads, friction=0.6) -> str:
    """What `limit` says of the kinematic verification of shapes on the ground, "" where it says nothing."""
    (tmp_path / "wall.json").write_text(json.dumps(block_file_of([GROUND, *shapes], friction)))
    case = tmp_path / "case.toml"
    case.write_text("\n".join(('[wall]\nblocks = "wall.json"\n[load]', *loads)))
    assert cli.main(["limit", str(case), "--output", str(tmp_path / "out"), "--force"]) == 0
    return "".join(line for line in capsys.readouterr().out.splitlines() if "kinematic verification" in line)


@pytest.mark.parametrize("courses", [1, 2, 5, 20])
def test_one_body_has_one_participation_however_many_stones_it_is_made_of(tmp_path, capsys, courses):
    """A wall of 1 x 0.2 x 1 m turns as a whole about its edge: e* = 1 of one body, a0* = (t / h) g. With e* of single
    stones a0* would grow with their number, to 4/3 of it."""
    cuts = [k / courses for k in range(courses + 1)]
    shapes = [box((0.0, 0.0, low), (1.0, 0.2, high)) for low, high in pairwise(cuts)]
    assert "e* = 1.000; a0* = λ g / e* = 1.962 m/s2 (0.200 g)" in kinematic_line(
        tmp_path, capsys, shapes, 'direction = "+y"'
    )


def test_slabs_that_slide_start_at_the_friction(tmp_path, capsys):
    """Five of them, all at the limit at 0.1: whatever share each slides by, all may slide on the ground."""
    slabs = [box((0.0, 0.0, 0.5 * k), (2.0, 0.6, 0.5 * k + 0.5)) for k in range(5)]
    said = kinematic_line(tmp_path, capsys, slabs, 'direction = "+x"', friction=0.1)
    assert "e* = 1.000; a0* = λ g / e* = 0.981 m/s2 (0.100 g)" in said


def test_a_mass_takes_part_where_it_rests_on_the_wall(tmp_path, capsys):
    """4 kN at 0.5 m and 4 kN on top of it, at 1 m, turn about the foot: (4 x 0.5 + 4 x 1)^2 / (8 (4 x 0.25 + 4 x 1)),
    and the multiplier is 8 x 0.1 / (4 x 0.5 + 4 x 1) = 2/15."""
    load = 'direction = "+y"\n[[load.dead]]\nblocks = [1]\nforce = "4 kN"\ninertia = true'
    said = kinematic_line(tmp_path, capsys, [box((0.0, 0.0, 0.0), (1.0, 0.2, 1.0))], load)
    assert "e* = 0.900; " in said
    assert f"({2 / 15 / 0.9:.3f} g)" in said


def test_a_participation_that_a_slow_body_lowers_raises_nothing(tmp_path, capsys):
    """A pyramid of 20 kN whose centre is at 0.75 m, 5 kN at its tip at 3 m: e* = 30^2 / (25 (11.25 + 45)) = 0.64, and
    the load that turns it over its foot is (20 + 5) x 0.5 / (20 x 0.75 + 5 x 3) = 0.4167 of g, not 0.651."""
    foot, tip = CUBE.vertices - [0.5, 0.5, 0.0], (CUBE.vertices - [0.5, 0.5, 0.0]) * [1e-3, 1e-3, 3.0]
    pyramid = Polyhedron(np.where(foot[:, 2:] > 0.5, tip, foot), CUBE.faces)
    load = 'direction = "+y"\n[[load.dead]]\nblocks = [1]\nforce = "5 kN"\ninertia = true'
    said = kinematic_line(tmp_path, capsys, [pyramid], load)
    assert "e* = 0.640 is below 0.75, and counts as 1; " in said
    assert "(0.417 g)" in said


def test_a_load_that_is_no_part_of_gravity_along_the_ground_has_no_such_verification(tmp_path, capsys):
    shapes = [box((0.0, 0.0, 0.0), (1.0, 0.2, 1.0))]
    assert kinematic_line(tmp_path, capsys, shapes, 'direction = "+z"') == ""
    assert kinematic_line(tmp_path, capsys, shapes, 'direction = "+y"', 'distribution = "mass_height"') == ""


SLAB = [box((0.0, 0.0, 0.0), (1.0, 0.2, 1.0))]
DEAD_LOAD = 'direction = "+y"\n[[load.dead]]\nblocks = [1]\nforce = "1 kN"'
WITHOUT_MASS = "kN of dead load have weight, but no mass in the seismic verification"


def printed(tmp_path, capsys, command, *loads) -> str:
    """What a command prints of a slab of 4 kN on the ground."""
    (tmp_path / "wall.json").write_text(json.dumps(block_file_of([GROUND, *SLAB])))
    case = tmp_path / "case.toml"
    case.write_text("\n".join(('[wall]\nblocks = "wall.json"\n[load]', *loads)))
    assert cli.main([command, str(case), "--output", str(tmp_path / "out")]) == 0
    return capsys.readouterr().out


@pytest.mark.parametrize("command", ["check", "limit"])
def test_dead_loads_without_mass_are_named(tmp_path, capsys, command):
    """Three loads of 1 kN, the second of which has mass, and the thrust of a roof, which has no weight."""
    own = '[[load.dead]]\nblocks = [1]\nforce = "1 kN"\n'
    thrust = own.replace("1 kN", "0.1 kN") + "direction = [0, 1, 0]"
    others = f"{own}inertia = true\n{own}{thrust}"
    said = printed(tmp_path, capsys, command, DEAD_LOAD, others)
    assert (
        f"WARNING: 2 {WITHOUT_MASS}; if they move with the wall, give inertia = true to load.dead.0, load.dead.2"
        in said
    )
    if command == "limit":
        assert WITHOUT_MASS in (tmp_path / "out" / "collapse.html").read_text()


@pytest.mark.parametrize("command", ["check", "limit"])
@pytest.mark.parametrize("loads", ['direction = "+y"', f"{DEAD_LOAD}\ninertia = true", DEAD_LOAD.replace("+y", "+z")])
def test_nothing_is_said_where_all_has_mass_or_nothing_is_verified(tmp_path, capsys, command, loads):
    assert WITHOUT_MASS not in printed(tmp_path, capsys, command, loads)


def corner(states: str = "range"):
    """The analysis of two bonded walls that meet in a corner, pushed away from the one that runs along the load."""

    load = SpaceLoadSettings(direction="-x")
    assemblage = find_joints(l_wall(Plan(2, 2, 4), Stones()))
    return load, analyse(assemblage, loads_on(assemblage.wall, load), SpaceLimitSettings(states=states))


def test_the_mechanism_is_that_of_the_lowest_state_found():
    """States lie from 0.306 to 0.448, the headline at 0.368: the start is 0.306 of g, as what moves is one body."""
    load, analysis = corner()
    low, high = analysis.range
    assert low < 0.9 * analysis.headline.load_multiplier < 0.9 * high
    assert analysis.lowest.load_multiplier == low
    found = starts_at(load, analysis)
    assert isinstance(found, StartsAt)
    assert found.multiplier == low
    assert found.acceleration == pytest.approx(low * GRAVITY / found.used, rel=1e-12)
    assert found.used == (found.participation if found.participation >= 0.75 else 1.0)
    assert found.participation == pytest.approx(1.0, abs=1e-3)


@pytest.mark.parametrize(
    ("setting", "said"),
    [
        (
            "none",
            "no state without dilation was looked for (limit_analysis.states): the associative multiplier is a",
        ),
        ("headline", "only the headline was looked for (limit_analysis.states): a lower state may have another"),
    ],
)
def test_a_mechanism_that_may_not_be_the_lowest_has_no_acceleration(tmp_path, capsys, setting, said):
    loads = ('direction = "+y"', "[limit_analysis]", f'states = "{setting}"')
    line = kinematic_line(tmp_path, capsys, SLAB, *loads)
    assert f"not made: {said}" in line
    assert "a0*" not in line


def test_a_wall_of_which_no_state_was_found_has_no_acceleration():
    load = SpaceLoadSettings(direction="+y")
    assemblage = find_joints(wall_of([GROUND, *SLAB], 0.6))
    analysis = analyse(assemblage, loads_on(assemblage.wall, load))
    assert isinstance(starts_at(load, analysis), StartsAt)
    lost = tuple(replace(state, error="flow") for state in analysis.states)
    assert starts_at(load, replace(analysis, states=lost)) == UPPER_BOUND


def test_what_was_not_looked_for_was_not_missed(tmp_path, capsys):
    said = printed(tmp_path, capsys, "limit", 'direction = "+y"', "[limit_analysis]", 'states = "none"')
    assert "an upper bound only, as no state with friction that does not dilate was looked for." in said
    assert "no state with friction that does not dilate was found" not in said
    page = (tmp_path / "out" / "collapse.html").read_text()
    assert re.search("without dilation</th><td>not looked for</td>", page)
    said = printed(tmp_path, capsys, "limit", 'direction = "+y"', "[limit_analysis]", 'states = "headline"')
    assert "it reaches the associative upper bound, and no lower one was looked for." in said
