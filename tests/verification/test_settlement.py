"""A support that gives way: least reaction of a beam, least thrust of two leaning blocks and of an arch."""

from __future__ import annotations

import json
import re
from math import pi, radians

import numpy as np
import pytest

from orchestrator.app.cli import main
from orchestrator.basis.errors import CaseError
from orchestrator.limit_analysis import settle
from tests.support.limit_analysis_cases import assemblage_of, box, case
from tests.support.undrawn import undrawn


def settled(assemblage, support, degrees):
    """Least reaction in N and the mechanism, checked by its power balance."""
    state = settle(assemblage, support, radians(degrees))
    assert state.equilibrium_residual < 1e-10
    assert state.yield_residual < 1e-9
    assert state.power_residual < 1e-8
    return -state.load_multiplier, state.mechanism


def test_beam_with_a_sinking_support():
    """It turns about the inner edge of the other support and hangs on the outer edge of this one."""
    L, a, h = 3.0, 0.4, 0.5
    beam = assemblage_of([box(0, -1, a, 1), box(L - a, -1, a, 1), box(0, 0, L, h)], fixed=(0, 1), friction=0.6)
    W = 20e3 * L * h
    reaction, mechanism = settled(beam, 1, -90)
    assert reaction == pytest.approx(W * (L / 2 - a) / (L - a), rel=1e-8)
    assert mechanism.velocities[1] == pytest.approx([0.0, -1.0, 0.0], abs=1e-8)
    assert mechanism.opening.min() > -1e-6
    assert mechanism.velocities[2][2] == pytest.approx(-1.0 / (L - a), rel=1e-6)


@pytest.mark.parametrize(("support", "degrees"), [(0, 180), (1, 0)])
def test_two_leaning_blocks_on_spreading_supports(support, degrees):
    """Three hinges: inner edges of the supports, top of the middle joint; H h = W (b/2 - a). Rough joints."""
    b, a, h = 1.0, 0.1, 0.8
    blocks = [box(0, -1, a, 1), box(2 * b - a, -1, a, 1), box(0, 0, b, h), box(b, 0, b, h)]
    leaning = assemblage_of(blocks, fixed=(0, 1), friction=5.0)
    reaction, mechanism = settled(leaning, support, degrees)
    assert reaction == pytest.approx(20e3 * b * h * (b / 2 - a) / h, rel=1e-8)
    assert mechanism.velocities[3][2] == pytest.approx(-mechanism.velocities[2][2], rel=1e-5)


def arch(voussoirs, ratio):
    """Semicircular arch of mean radius 1, straight voussoirs; supports 0 (right) and 1 (left)."""
    angles = np.linspace(0.0, pi, voussoirs + 1)
    rays = np.column_stack([np.cos(angles), np.sin(angles)])
    inner, outer = (1 - ratio / 2) * rays, (1 + ratio / 2) * rays
    stones = [[inner[k], outer[k], outer[k + 1], inner[k + 1]] for k in range(voussoirs)]
    return assemblage_of([box(0.5, -0.5, 1.0, 0.5), box(-1.5, -0.5, 1.0, 0.5), *stones], fixed=(0, 1), friction=2.0)


def test_arch_on_spreading_supports_has_heymans_least_thrust():
    """Highest line of thrust: extrados at the crown, intrados at the haunches. H = max over joints at angle a from the
    springing of (moment of the weight above about the joint's intrados) / (rise from there to the crown's extrados)."""
    voussoirs, ratio = 40, 0.2
    wall = arch(voussoirs, ratio)
    stones = [block.polygon for block in wall.wall.blocks[2:]]
    areas, middles = [], []
    for p in stones:
        x, y = p.T
        cross = x * np.roll(y, -1) - np.roll(x, -1) * y
        areas.append(0.5 * cross.sum())
        middles.append(((x + np.roll(x, -1)) * cross).sum() / (6 * areas[-1]))
    weights, middles = 20e3 * np.array(areas), np.array(middles)
    thrusts = []
    for k in range(voussoirs // 2):
        a = pi * k / voussoirs
        x, y = (1 - ratio / 2) * np.cos(a), (1 - ratio / 2) * np.sin(a)
        above = slice(k, voussoirs // 2)
        thrusts.append(float(np.sum(weights[above] * (x - middles[above])) / (1 + ratio / 2 - y)))
    reaction, _ = settled(wall, 0, 0)
    assert reaction == pytest.approx(max(thrusts), rel=1e-8)


def test_a_support_that_is_not_needed_bears_nothing():
    """A block stands on one support by itself: the power of its mechanism was out of balance by 10, as both are noise,
    and the reaction was -0.0000 kN."""
    wall = assemblage_of([box(0, -1, 1, 1), box(1, -1, 0.2, 1), box(0, 0, 1.2, 1)], fixed=(0, 1))
    state = settle(wall, 1, -np.pi / 2)
    assert state.load_multiplier == 0.0
    assert state.power_residual < 1e-6


def test_only_supports_settle():
    with pytest.raises(CaseError, match=r"settlement\.support: block 3 is not a support; supports are 0"):
        settle(case("tower_5_blocks"), 3, 0.0)


LINTEL = """
[wall]
blocks = "lintel.json"
[[load.cases]]
name = "right"
[[load.cases]]
name = "left"
direction = "-x"
{more}
"""
LOADED = "[[load.cases]]\nname = 'loaded'\ndead = [{blocks = [3], force = '50 kN'}]\n"


def least_reactions(folder, capsys, more):
    """Return what `limit --settle` prints of the right support, by load cases: reactions in kN, and its pictures."""
    places = {
        0: (-0.5, -0.2, 1, 0.2),
        9: (2.2, -0.2, 1, 0.2),
        1: (0, 0, 0.4, 1),
        2: (2.3, 0, 0.4, 1),
        3: (0, 1, 2.7, 0.4),
    }
    blocks = [
        {"id": n, "polygon": [list(map(float, corner)) for corner in box(*place)], "fixed": n in (0, 9)}
        for n, place in places.items()
    ]
    record = {"units": {"length": "m", "unit_weight": "kN/m3"}, "thickness": 0.3, "friction": 0.6, "unit_weight": 20.0}
    (folder / "lintel.json").write_text(json.dumps(record | {"blocks": blocks}))
    (folder / "lintel.toml").write_text(LINTEL.format(more=more))
    with undrawn():
        assert main(["limit", str(folder / "lintel.toml"), "--settle", "9", "--output", str(folder / "out")]) == 0
    said = capsys.readouterr().out
    found = re.findall(r"^(?:(.*): )?support 9 .* least reaction ([0-9.]+) kN", said, re.MULTILINE)
    pictures = sorted(path.relative_to(folder / "out") for path in folder.rglob("settlement.png"))
    return {name: float(value) for name, value in found}, [path.parts[0] for path in pictures]


def test_a_support_gives_way_under_the_dead_loads_of_every_load_case(tmp_path, capsys):
    """A post of 2.4 kN and its part of a lintel of 6.48 kN (and 50 kN) in the middle of 2.7 m: the lintel turns about
    the other post's inner edge at 0.4 m and hangs on this one's outer edge, 2.3 m from there."""
    reaction = [2.4 + load * (1.35 - 0.4) / 2.3 for load in (6.48, 56.48)]
    found, pictures = least_reactions(tmp_path, capsys, LOADED)
    assert found == pytest.approx({"right, left": reaction[0], "loaded": reaction[1]}, abs=1e-4)
    assert pictures == ["loaded", "right"]


def test_load_cases_that_share_their_dead_loads_have_one_settlement(tmp_path, capsys):
    found, pictures = least_reactions(tmp_path, capsys, "")
    assert found == pytest.approx({"": 2.4 + 6.48 * (1.35 - 0.4) / 2.3}, abs=1e-4)
    assert pictures == ["figures"]
