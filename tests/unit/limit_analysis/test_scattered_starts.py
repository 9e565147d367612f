"""Starts around known slips: as many as asked for, none negative, the same for a wall and its mirror image."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from orchestrator.joints import JointSettings, find_joints
from orchestrator.limit_analysis.scattered_starts import scattered_starts
from orchestrator.masonry.readers import read_blocks

WALL = read_blocks(Path(__file__).parents[2] / "data" / "ferris_tinloi_wall3.json")


def mirrored(wall):
    blocks = tuple(replace(block, polygon=(block.polygon * [-1.0, 1.0])[::-1].copy()) for block in wall.blocks)
    return replace(wall, blocks=blocks[::-1])


def by_place(assemblage, direction):
    """A slip that depends on where a joint is, and the joints' places, rounded."""
    x, y = (assemblage.midpoint * [direction, 1.0]).T
    return np.abs(np.sin(7.0 * x + 3.0 * y)), [tuple(place) for place in np.round([x, y], 6).T]


def starts(wall, direction):
    assemblage = find_joints(wall, JointSettings())
    slip, places = by_place(assemblage, direction)
    found = list(scattered_starts(assemblage, direction, slip, 4))
    return slip, [dict(zip(places, start, strict=True)) for start in found]


def test_a_wall_seen_from_behind_has_the_same_starts():
    _, here = starts(WALL, 1)
    _, there = starts(mirrored(WALL), -1)
    assert len(here) == 4
    for one, other in zip(here, there, strict=True):
        assert one.keys() == other.keys()
        assert [other[place] for place in one] == pytest.approx(list(one.values()))


def test_starts_differ_and_let_every_joint_slide():
    slip, found = starts(WALL, 1)
    values = np.array([list(start.values()) for start in found])
    assert (values > 0.0).all()
    assert (values.std(axis=0) > 0.0).all()
    assert np.corrcoef(np.log(values.mean(axis=0)), np.log(slip + 1e-3))[0, 1] > 0.3, "they keep the pattern"
