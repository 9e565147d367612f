"""Tension cut-off, cohesion, crushing and joint classes against one block written out by hand.

W weight, N_t = f_t b t, N_c = f_c b t of a joint b wide in a wall of thickness t; plastic stress blocks of f_t and f_c.
"""

from __future__ import annotations

from dataclasses import replace
from math import radians

import numpy as np
import pytest

from orchestrator.basis.arrays import read_only
from orchestrator.basis.errors import CaseError
from orchestrator.limit_analysis import analyse
from orchestrator.limit_analysis.remarks import BONDED, CRUSHING, NO_PATH
from orchestrator.loads import LoadSettings, loads_on
from orchestrator.masonry.joint_warnings import idle_classes, strengths_beyond_the_cone
from orchestrator.masonry.joints import JointClass, JointSettings, find_joints
from orchestrator.masonry.wall import Block, Wall
from tests.support.limit_analysis_cases import analysed, answers, assemblage_of, box, case, mirrored

FLOOR = box(-3.0, -0.5, 6.0, 0.5)
ROUGH = 5.0
CHORDS = 1e-3
"""What chords may cost in bending, at most: the documented error of the linearisation, on the safe side."""


def block(width, height, *strengths, friction=ROUGH, thickness=0.2):
    """One block of 20 kN/m3 on a floor, with a joint of the strengths given."""
    wall = assemblage_of([FLOOR, box(-width / 2, 0.0, width, height)], friction=friction, thickness=thickness)
    return find_joints(wall.wall, JointSettings(classes=strengths))


def multipliers(assemblage, loads=None):
    """Associative and sequence multiplier, and the headline, of checked states."""
    found = analyse(assemblage, loads=loads and loads_on(assemblage.wall, loads))
    assert all(
        one in (NO_PATH, BONDED, CRUSHING) or one.startswith(("in large displacements", "from "))
        for one in found.remarks
    )
    assert (BONDED in found.remarks) == bool(assemblage.joints.cohesion.any())
    for state in (found.associative, found.sequence, found.headline):
        assert state.equilibrium_residual < 1e-10
        assert state.yield_residual < 1e-9
        assert state.power_residual < 1e-7
    return np.array([state.load_multiplier for state in (found.associative, found.sequence, found.headline)])


def test_what_a_later_class_gives_is_no_strength_beyond_the_cone():
    """The earlier class reaches its strength in the bed, the later one gives less in the joint beside the block."""
    blocks = (
        Block(0, np.array(FLOOR), True, 20e3),
        *(Block(k, np.array(box(k, 0, 1, 1)), False, 20e3) for k in (1, 2)),
    )
    classes = (JointClass(cohesion=1e5, tensile_strength=1e5), JointClass(orientation="head", tensile_strength=5e4))
    assemblage = find_joints(Wall("two", blocks, 0.3, 0.5), JointSettings(classes=classes))
    assert sorted(assemblage.joints.tensile_strength) == [5e4, 1e5, 1e5]
    assert strengths_beyond_the_cone(assemblage, classes) == []


def test_the_thickness_of_mortar_is_used_where_a_modulus_of_its_class_is():
    """The later class gives another modulus with a thickness of its own, or the stiffness itself."""
    blocks = (Block(0, np.array(FLOOR), True, 20e3), Block(1, np.array(box(0, 0, 1, 1)), False, 20e3))
    first = JointClass(mortar_modulus=1e9, mortar_thickness=0.01)
    shear = (first, JointClass(mortar_shear_modulus=4e8, mortar_thickness=0.02))
    assemblage = find_joints(Wall("one", blocks, 0.3, 0.5), JointSettings(classes=shear))
    assert (*assemblage.joints.normal_stiffness, *assemblage.joints.shear_stiffness) == pytest.approx((1e11, 2e10))
    assert idle_classes(assemblage, shear) == []
    (said,) = idle_classes(assemblage, (first, JointClass(normal_stiffness=4e8)))
    assert said.endswith("not used: mortar_modulus, mortar_thickness")


@pytest.mark.parametrize("direction", ["+x", "-x"])
def test_tension_holds_a_rocking_block(direction):
    """lambda W h/2 = (W + N_t) b/2."""
    b, h, t, f_t = 0.5, 1.0, 0.2, 30e3
    W, N_t = 20e3 * b * h * t, f_t * b * t
    glued = block(b, h, JointClass(cohesion=ROUGH * f_t, tensile_strength=f_t), thickness=t)
    assert multipliers(glued, LoadSettings(direction)) == pytest.approx(b / h * (1 + N_t / W), abs=1e-6)


def test_tension_ends_where_the_cone_does_without_cohesion_too():
    """A block without cohesion rocks at b / h, as in finite elements, and the class's strength is told to be less."""
    glued = block(0.5, 1.0, strong := JointClass(tensile_strength=30e3))
    assert multipliers(glued) == pytest.approx(0.5, abs=1e-6)
    (said,) = strengths_beyond_the_cone(glued, [strong])
    assert said.startswith("WARNING: joints.classes.0.tensile_strength: 0.03 MPa is more than cohesion over friction")
    within = JointClass(tensile_strength=30e3, cohesion=ROUGH * 30e3)
    assert not strengths_beyond_the_cone(block(0.5, 1.0, within), [within])


@pytest.mark.parametrize(("cohesion", "least"), [(1e6, 30e3), (3e3, 3e3 / 0.6)])
def test_tension_holds_a_block_that_is_lifted(cohesion, least):
    """(lambda - 1) W = N_t, or where Coulomb's cone ends before: c/mu."""
    b, h, t = 0.5, 1.0, 0.2
    glued = block(b, h, JointClass(tensile_strength=30e3, cohesion=cohesion), friction=0.6, thickness=t)
    expected = 1 + least * b * t / (20e3 * b * h * t)
    up = loads_on(glued.wall, LoadSettings(inclination=radians(90)))
    assert analyse(glued, loads=up).associative.load_multiplier == pytest.approx(expected, abs=1e-8)


@pytest.mark.parametrize("ratio", [1e-7, 1e-4, 1e-3, 0.01, 0.05, 0.1, 0.3, 0.5, 0.8, 0.95])
@pytest.mark.parametrize("tension", [0.0, 0.25])
def test_crushing_of_a_rocking_block(ratio, tension):
    """lambda W h/2 = (W + N_t)/2 (b - (W + N_t)/((f_c + f_t) t)), at most 0.1 % below and never above: chords."""
    b, h, t = 0.5, 1.0, 0.2
    W = 20e3 * b * h * t
    f_c = W / (ratio * b * t)
    f_t = tension * W / (b * t)
    law = JointClass(compressive_strength=f_c, cohesion=ROUGH * f_t, tensile_strength=f_t)
    found = multipliers(block(b, h, law, thickness=t))
    N_t = f_t * b * t
    expected = (W + N_t) / (W * h) * (b - (W + N_t) / ((f_c + f_t) * t))
    assert np.all(found <= expected * (1 + 1e-8))
    assert np.all(found >= expected * (1 - CHORDS))


def test_crushing_limits_a_vertical_load():
    """(1 + lambda) W = N_c, exactly: the last chord ends there."""
    b, h, t, f_c = 0.5, 1.0, 0.2, 1e6
    W = 20e3 * b * h * t
    crushed = block(b, h, JointClass(compressive_strength=f_c), thickness=t)
    down = loads_on(crushed.wall, LoadSettings(inclination=radians(-90)))
    assert analyse(crushed, loads=down).associative.load_multiplier == pytest.approx(f_c * b * t / W - 1, rel=1e-8)


def test_a_block_too_heavy_for_its_joint_cannot_stand():
    with pytest.raises(CaseError, match="cannot stand"):
        analyse(block(0.5, 1.0, JointClass(compressive_strength=19e3)))


@pytest.mark.parametrize(("strength", "within"), [(np.inf, 1e-12), (1e15, 1e-8), (1e12, 1e-5), (1e9, 1e-3)])
def test_strength_without_end_returns_the_wall_without(strength, within):
    """A joint of 0.1 m x 0.1 m bears 1e10 N at 1e12 N/m2, the wall weighs 7,875 N: 8e-7 of the moment is lost."""
    wall = case("ferris_tinloi_wall4")
    joints = replace(wall.joints, compressive_strength=read_only(np.full(wall.joints.count, strength)))
    strong = replace(wall, joints=joints)
    expected = answers("ferris_tinloi_wall4").associative.load_multiplier
    assert analyse(strong).associative.load_multiplier == pytest.approx(expected, rel=within)


def test_a_wall_with_all_strengths_and_its_mirror_image():
    wall = case("ferris_tinloi_wall3")
    classes = (
        JointClass(compressive_strength=0.5e6),
        JointClass(orientation="bed", cohesion=500.0, tensile_strength=200.0),
        JointClass(orientation="head", friction=0.4),
    )
    strong, image = (find_joints(w.wall, JointSettings(classes=classes)) for w in (wall, mirrored(wall)))
    found, other = analyse(strong).associative, analysed(image, -1).associative
    assert other.load_multiplier == pytest.approx(found.load_multiplier, abs=1e-8)
    for state in (found, other):
        assert state.equilibrium_residual < 1e-10
        assert state.yield_residual < 1e-9
        assert state.power_residual < 1e-7


@pytest.mark.parametrize(("orientation", "expected"), [("bed", 0.3), ("head", 0.6), ("any", 0.3)])
def test_classes_by_orientation(orientation, expected):
    """A block that slides on its bed joint, free at its head joint."""
    stones = [FLOOR, box(0.0, 0.0, 1.0, 0.4), box(-1.0, 0.0, 1.0, 0.4)]
    wall = assemblage_of(stones, friction=0.6).wall
    assemblage = find_joints(wall, JointSettings(classes=(JointClass(orientation=orientation, friction=0.3),)))
    head = (assemblage.joints.i > 0) & (assemblage.joints.j > 0)
    assert assemblage.joints.friction[head] == (0.6 if orientation == "bed" else 0.3)
    assert analyse(assemblage).associative.load_multiplier == pytest.approx(expected, abs=1e-8)


def test_classes_by_pair_of_materials():
    """Of three joints in a stack only that between stone and brick, named in either order, is smooth."""
    stack = assemblage_of([FLOOR, *(box(-1.0, 0.4 * level, 2.0, 0.4) for level in range(3))], friction=0.6).wall
    materials = ("stone", "stone", "stone", "brick")
    named = replace(stack, blocks=tuple(replace(b, material=m) for b, m in zip(stack.blocks, materials, strict=True)))
    for pair in (("brick", "stone"), ("stone", "brick")):
        joints = find_joints(named, JointSettings(classes=(JointClass(between=pair, friction=0.2),))).joints
        assert joints.friction.tolist() == [0.6, 0.6, 0.2]
    same = find_joints(named, JointSettings(classes=(JointClass(between=("stone", "stone"), friction=0.2),))).joints
    assert same.friction.tolist() == [0.2, 0.2, 0.6]


def test_the_last_class_that_fits_counts_value_by_value():
    classes = (JointClass(friction=0.5, cohesion=1e3), JointClass(orientation="bed", friction=0.4))
    joint = block(1.0, 1.0, *classes)
    assert (joint.joints.friction.tolist(), joint.joints.cohesion.tolist()) == ([0.4], [1e3])


@pytest.mark.parametrize("between", [("stone",), ("stone", "marble"), ("stone",) * 3])
def test_classes_name_two_materials_of_the_wall(between):
    with pytest.raises(CaseError, match=r"joints\.classes\.0\.between"):
        block(1.0, 1.0, JointClass(between=between, friction=0.3))
