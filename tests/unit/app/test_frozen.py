"""Values are frozen: no array that a value holds, or hands out, can be written to. (A frozen dataclass does not see to
that.)"""

from __future__ import annotations

from dataclasses import fields, is_dataclass

import numpy as np
import pytest

from orchestrator import (
    Block,
    JointSettings,
    SteppingSettings,
    Wall,
    analyse,
    find_joints,
    loads_on,
    macroblocks_of,
    make_bodies,
    merged,
    one_body,
    one_body_per_block,
    push,
    read_blocks,
)
from orchestrator.loads import LoadSettings
from orchestrator.macroblocks.criteria import MacroblockSettings
from orchestrator.masonry.patterns import ARCHED_FACADE, Rubble, arched_wall, rubble
from tests.support.paths import DATA


def arrays_of(value, name, seen):
    """Yield name and array of all that a value holds, of what that holds, and of what their properties return."""
    if isinstance(value, np.ndarray):
        yield name, value
    elif isinstance(value, tuple | list | frozenset):
        for number, one in enumerate(value):
            yield from arrays_of(one, f"{name}[{number}]", seen)
    elif isinstance(value, dict):
        for key, one in value.items():
            yield from arrays_of(one, f"{name}[{key!r}]", seen)
    elif is_dataclass(value) and id(value) not in seen:
        seen[id(value)] = value
        kind = type(value)
        for one in fields(kind):
            yield from arrays_of(getattr(value, one.name), f"{name}.{one.name}", seen)
        for key in dir(kind):
            if isinstance(getattr(kind, key), property) and not is_dataclass(handed_out := getattr(value, key)):
                yield from arrays_of(handed_out, f"{name}.{key}", seen)


def writeable(value):
    found = dict(arrays_of(value, type(value).__name__, {}))
    assert found, "no array in it"
    return sorted(name for name, array in found.items() if array.flags.writeable)


@pytest.fixture(scope="module")
def chain():
    assemblage = find_joints(read_blocks(DATA / "ferris_tinloi_wall1.json"), JointSettings())
    loads = loads_on(assemblage.wall, LoadSettings())
    analysis = analyse(assemblage, loads=loads)
    partition = macroblocks_of(assemblage, analysis)
    pushed = push(assemblage, analysis, partition, stepping=SteppingSettings(final_displacement=2e-4))
    given = MacroblockSettings(tol_n=0.1, tol_d=0.5)
    return {
        "wall": assemblage.wall,
        "assemblage": assemblage,
        "loads": loads,
        "analysis": analysis,
        "partition": partition,
        "merged": merged(assemblage, analysis.headline.mechanism, given),
        "one body": one_body(assemblage),
        "every stone": one_body_per_block(assemblage),
        "bodies": make_bodies(assemblage, partition, analysis.headline.joint_forces),
        "pushed": pushed,
    }


SMALL = Rubble(1.8, 1.6, stone=0.6, seed=1)
NAMES = (
    "wall", "assemblage", "loads", "analysis", "partition", "merged", "one body", "every stone", "bodies", "pushed",
)  # fmt: skip


@pytest.mark.parametrize("name", NAMES)
def test_no_array_of_a_value_can_be_written_to(chain, name):
    assert writeable(chain[name]) == []


@pytest.mark.parametrize("made", [lambda: rubble(SMALL), lambda: arched_wall(ARCHED_FACADE)])
def test_no_array_of_a_wall_without_a_drawing_can_be_written_to(made):
    assert writeable(made()) == []


def test_a_block_has_its_corners_for_itself():
    corners = np.array([[0.0, 0.0], [1.0, 0.0], [1.0, 1.0]])
    block = Block(1, corners, False, 2e4)
    corners[2] = 9.0
    assert block.polygon.tolist() == [[0, 0], [1, 0], [1, 1]]
    with pytest.raises(ValueError, match="read-only"):
        block.polygon[:] *= 2.0
    assert writeable(Wall("one", (block,), 0.3, 0.6)) == []
