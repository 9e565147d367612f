"""Mechanisms verified by the kinematic approach: the rocking block of docs/seismic.md by hand, floors, bond, bodies."""

from __future__ import annotations

from dataclasses import replace
from math import atan, cos, pi, sin, sqrt

import numpy as np
import pytest

from orchestrator.assessment.seismic.kinematic import Kinematics
from orchestrator.assessment.seismic.kinematic_checks import (
    LOWEST_ALONE,
    NOT_TURNING,
    SEVERAL_TURNS,
    kinematic_checks,
)
from orchestrator.assessment.seismic.local_mechanism import UPPER_BOUND, InMechanism, loads_in_mechanism
from orchestrator.assessment.seismic.seismic_verification import verify
from orchestrator.assessment.seismic.settings import SeismicSettings, limit_states
from orchestrator.limit_analysis import LimitAnalysisSettings, analyse
from orchestrator.loads import DeadLoad, LiveLoad, LoadSettings, loads_on
from orchestrator.masonry.joints import JointClass, JointSettings, find_joints
from orchestrator.masonry.wall import Wall
from tests.support.limit_analysis_cases import answers, case
from tests.support.walls import of_file, upright

FORWARD = np.array([1.0, 0.0])

G, AG = 9.81, 0.15 * 9.81
WIDTH, HEIGHT, THICKNESS = 0.5, 1.0, 1.0


def wall_of(*blocks, friction=2.0):
    return Wall("", (upright(0, -5, -1, 12, 1, fixed=True), *blocks), THICKNESS, friction)


def rocking(height=1.0, weight=10e3, stones=1):
    """A block 0.5 m wide of `weight` N, in courses that are as many stones."""
    each = height / stones
    blocks = (upright(k + 1, 0, k * each, WIDTH, each, weight / (WIDTH * height * THICKNESS)) for k in range(stones))
    return find_joints(wall_of(*blocks), JointSettings())


def bonded(tension, cohesion, friction=2.0):
    """The same block on a bed joint with tensile strength and cohesion in Pa."""
    joints = JointSettings(classes=(JointClass(cohesion=cohesion, tensile_strength=tension),))
    return find_joints(wall_of(upright(1, 0, 0, WIDTH, 1.0), friction=friction), joints)


def checked(assemblage, load=None, **settings):
    """Return the summary's record of the mechanism and its rows by (approach, limit state)."""
    load = load or LoadSettings()
    analysis = analyse(assemblage, loads=loads_on(assemblage.wall, load))
    asked = SeismicSettings(AG, ground="B", **settings)
    found = loads_in_mechanism(assemblage, load, LimitAnalysisSettings(), analysis)
    record, rows = kinematic_checks(asked, limit_states(asked), found, load.vector)
    return record, {(row["approach"], row["limit_state"]): row for row in rows}


def test_rocking_block_by_hand():
    """docs/seismic.md. a_0* = 0.5 x 9.81/1.35; d_SLV = 0.1 m; T_SLV = 1.68 pi sqrt(0.1 / (0.6 a_0*)) = 1.130 s."""
    record, rows = checked(rocking())
    start = 0.5 * G / 1.35
    assert record["e_star"] == pytest.approx(1.0)
    assert record["bodies"] == 1
    assert record["a0_star_m_per_s2"] == pytest.approx(start, rel=1e-6)
    assert record["d0_star_m"] == pytest.approx(0.25, rel=1e-6)
    linear, rocks = rows["kinematic, linear", "SD"], rows["kinematic, non-linear", "SD"]
    assert linear["demand"] == pytest.approx(AG * 1.2 / 2)
    assert linear["safety_ratio"] == pytest.approx(4.115, abs=1e-3)
    period = 1.68 * pi * sqrt(0.1 / (0.6 * start))
    assert rocks["capacity"] == pytest.approx(0.1, rel=1e-6)
    assert rocks["period_s"] == pytest.approx(period, rel=1e-6)
    assert rocks["period_s"] == pytest.approx(1.130, abs=1e-3)
    needed = AG * 1.2 * 2.5 * sqrt(10 / 13) * 0.5 / period * (period / (2 * pi)) ** 2
    assert rocks["demand"] == pytest.approx(needed, rel=1e-6)
    assert rocks["safety_ratio"] == pytest.approx(0.1 / needed, rel=1e-6)
    assert rocks["safety_ratio"] == pytest.approx(1.805, abs=1e-3)
    # it does not move below a_g = a_0*/S, ratio 2.058, which the clause allows
    assert start / 1.2 / AG == pytest.approx(2.0576, abs=1e-4)
    assert any("3.028 m/s2 only: C8.7.1.2.1.8 allows ratio 2.058" in text for text in rocks["remarks"])
    assert any("EN 1998-3 has no kinematic approach: SD as SLV" in text for text in rocks["remarks"])
    assert LOWEST_ALONE in rocks["remarks"], "it passes"


def test_near_collapse_by_hand():
    """d_SLC = 0.6 x 0.25 = 0.15 m, a = 0.4 a_0*, T_SLC = 1.56 pi sqrt(0.15 / (0.4 a_0*)) = 1.574 s, 10 % of damping."""
    _, rows = checked(rocking(), limit_state="NC")
    assert list(rows) == [("kinematic, non-linear", "NC")]
    row = rows["kinematic, non-linear", "NC"]
    period = 1.56 * pi * sqrt(0.15 / (0.4 * 0.5 * G / 1.35))
    assert row["capacity"] == pytest.approx(0.15, rel=1e-6)
    assert row["period_s"] == pytest.approx(period, rel=1e-6)
    assert row["period_s"] == pytest.approx(1.5745, abs=1e-4)
    assert row["demand"] == pytest.approx(AG * 1.2 * 2.5 * sqrt(10 / 15) * 0.5 * period / (4 * pi**2), rel=1e-6)


def test_damage_limitation_is_the_start_of_the_motion():
    _, rows = checked(rocking(), limit_state="DL")
    assert list(rows) == [("kinematic, activation", "DL")]
    row = rows["kinematic, activation", "DL"]
    assert row["demand"] == pytest.approx(AG * 1.2)
    assert row["safety_ratio"] == pytest.approx(0.5 * G / 1.35 / (AG * 1.2), rel=1e-6)


def test_at_the_top_of_a_building_the_demand_is_that_of_its_floor():
    """z = 6 m of 9 m, 3 storeys, T_1 = 0.3 s: a_Z = 3.8028 m/s2 (test_spectrum.py), half of it for q = 2."""
    building = {"mechanism_height": 6.0, "building_height": 9.0, "building_period": 0.3, "storeys": 3}
    _, rows = checked(rocking(), **building)
    assert rows["kinematic, linear", "SD"]["demand"] == pytest.approx(1.9014, abs=1e-4)
    # T_SLV = 1.130 s is far beyond T_1, where the ground's spectrum is the larger one: demand as without a building
    on_ground = AG * 1.2 * 2.5 * sqrt(10 / 13) * 0.5 * rows["kinematic, non-linear", "SD"]["period_s"] / (4 * pi**2)
    assert rows["kinematic, non-linear", "SD"]["demand"] == pytest.approx(on_ground, rel=1e-6)


@pytest.mark.parametrize("stones", [1, 2, 5])
def test_a_rigid_panel_has_one_verification_however_many_stones_it_is_made_of(stones):
    """H3: 0.5 x 2 m turns as one; one stone or many, e* = 1, a_0* = 0.25 g/FC, d_0* = 0.25 m."""
    record, _ = checked(rocking(2.0, 20e3, stones))
    assert record["bodies"] == 1
    assert record["e_star"] == pytest.approx(1.0, abs=1e-6)
    assert record["a0_star_m_per_s2"] == pytest.approx(0.25 * G / 1.35, rel=1e-5)
    if stones == 1:
        assert record["d0_star_m"] == pytest.approx(0.25, rel=1e-5)


def test_a_heavy_block_and_a_light_one_with_a_floor_at_the_same_height_have_the_same_verification():
    """H1: 100 kN, or 10 kN and 90 kN with inertia at its centroid."""
    load = LoadSettings(dead=(DeadLoad(blocks=(1,), force=90e3, inertia=True),))
    (heavy, rows), (light, others) = checked(rocking(weight=100e3)), checked(rocking(), load)
    for key in ("alpha0", "e_star", "a0_star_m_per_s2", "d0_star_m"):
        assert light[key] == pytest.approx(heavy[key], rel=1e-5), key
    for name, row in rows.items():
        assert others[name]["safety_ratio"] == pytest.approx(row["safety_ratio"], rel=1e-5)


def test_a_floor_on_top_counts_in_participation_and_displacement():
    """H1, by hand: 10 kN at 0.5 m and 90 kN at 1 m. alpha_0 = 100 x 0.25 / 95.

    e* = 95^2 / (100 x 92.5); balance at tan(theta) = 25/95, where both are displaced by r sin + 0.25 (1 - cos).
    """
    load = LoadSettings(dead=(DeadLoad(blocks=(1,), line_load=180e3, inertia=True),))
    record, _ = checked(rocking(), load)
    assert record["alpha0"] == pytest.approx(25 / 95, rel=1e-5)
    assert record["e_star"] == pytest.approx(0.9757, abs=1e-4)
    angle = atan(25 / 95)
    low, high = (level * sin(angle) + 0.25 * (1 - cos(angle)) for level in (0.5, 1.0))
    assert record["d0_star_m"] == pytest.approx((5 * low + 90 * high) / 95, rel=1e-4)
    assert record["d0_star_m"] == pytest.approx(0.256, abs=1e-4)


def test_a_floor_without_mass_is_told_beside_every_row_that_leaves_it_out():
    """By hand: 10 kN of stone and 90 kN of floor without inertia, given twice."""
    dead = (DeadLoad(blocks=(1,), force=90e3), DeadLoad(blocks=(1,), force=1.0, inertia=True))
    assemblage = rocking()

    def remarks(*dead):
        load = LoadSettings(dead=dead)
        analysis = analyse(assemblage, loads=loads_on(assemblage.wall, load))
        asked = SeismicSettings(AG, ground="B")
        record, _ = verify(asked, load, LimitAnalysisSettings(), assemblage, analysis, [])
        return [[text for text in row["remarks"] if text.startswith("WARNING")] for row in record["checks"]]

    said = (
        "WARNING: 90 kN of dead load have weight, but no mass in the seismic verification; if they move with the wall, "
        "give inertia = true to load.dead.0"
    )
    assert remarks(*dead) == [[said], [said]]
    assert remarks(replace(dead[0], inertia=True)) == [[], []]


def test_a_floor_without_mass_does_work_only():
    """10 kN with mass, 90 kN without: alpha_0 = 100 x 0.25 / (10 x 0.5), e* = 1.

    Balance: 10 (0.25 cos - 0.5 sin) + 90 (0.25 cos - 1 sin) = 0, the same angle as with mass, and d of the 10 kN.
    """
    load = LoadSettings(dead=(DeadLoad(blocks=(1,), line_load=180e3),))
    record, _ = checked(rocking(), load)
    assert record["alpha0"] == pytest.approx(5.0, rel=1e-5)
    assert record["e_star"] == pytest.approx(1.0)
    angle = atan(25 / 95)
    assert record["d0_star_m"] == pytest.approx(0.5 * sin(angle) + 0.25 * (1 - cos(angle)), rel=1e-4)


@pytest.mark.parametrize(
    "load",
    [
        LoadSettings(distribution="per_block", live=(LiveLoad(blocks=(1,), force=1.0),)),
        LoadSettings(distribution="per_block", live=(LiveLoad(blocks=(1,), force=1e6),)),
        LoadSettings(distribution="mass_height"),
        LoadSettings(inclination=-pi / 3),
        LoadSettings(direction="-x", distribution="per_block", live=(LiveLoad(blocks=(1,), force=1e3),)),
    ],
)
def test_other_loads_are_analysed_for_a_horizontal_one_in_proportion_to_mass(load):
    """H2: 0.5 g whatever the live load is, and in whatever unit."""
    record, rows = checked(rocking(), load)
    assert record["alpha0"] == pytest.approx(0.5, rel=1e-6)
    assert rows["kinematic, linear", "SD"]["safety_ratio"] == pytest.approx(4.115, abs=1e-3)
    assert "not for the load of this case" in rows["kinematic, linear", "SD"]["remarks"][0]


@pytest.mark.parametrize(("tension", "start"), [(10e3, 0.75), (50e3, 1.75)])
def test_a_bond_that_has_opened_bears_nothing(tension, start):
    """By hand, W = 10 kN, 0.5 x 1 m on a bed of 0.5 m2 whose tension is at its ends: it starts at
    (W 0.25 + f_t 0.5/2 x 0.5)/(W 0.5); then it is the dry block, 0.5 g, d_0* = 0.25 m. With 10 kPa d_0* was 0.375 m."""
    record, rows = checked(bonded(tension, 100e3))
    assert record["alpha0"] == pytest.approx(start, rel=1e-6)
    assert record["alpha0_opened"] == pytest.approx(0.5, rel=1e-6)
    assert record["d0_star_m"] == pytest.approx(0.25, rel=1e-6)
    assert record["friction_share"] == pytest.approx(0.0, abs=1e-8), "as sharp as a limit state is met"
    _, dry = checked(rocking())
    for name, row in rows.items():
        for key in ("demand", "capacity", "safety_ratio"):
            assert row[key] == pytest.approx(dry[name][key], rel=1e-6), (name, key)
        assert f"a bond that has opened bears nothing: alpha_0 = 0.5000 then, {start:.4f} to open it" in row["remarks"]
    _, activation = checked(bonded(tension, 100e3), limit_state="DL")
    assert activation["kinematic, activation", "DL"]["capacity"] == pytest.approx(start * G / 1.35, rel=1e-6)


def test_a_bond_that_slides_open_is_gone_too():
    """Friction 0.3 and 10 kPa of cohesion on 0.5 m2: it slides at 0.8, then at 0.3, and has no d_0*."""
    record, rows = checked(bonded(100e3, 10e3, friction=0.3))
    assert record["alpha0"] == pytest.approx(0.8, rel=1e-6)
    assert record["alpha0_opened"] == pytest.approx(0.3, rel=1e-6)
    assert rows["kinematic, non-linear", "SD"]["refused"] == NOT_TURNING


def test_a_wall_that_falls_once_its_bond_has_opened_has_only_its_start():
    """A stone glued to the side of a block hangs on its bond: what bears no more lets it fall.

    It turns about its lower edge: 1.25 kN of bond at the upper one hold 2.5 kN that hang and 2.5 kN times alpha_0."""
    wall = wall_of(upright(1, 0, 0, 3.0, 1.0), upright(2, 3.0, 0.25, 0.25, 0.5))
    glue = JointSettings(classes=(JointClass(orientation="head", cohesion=30e3, tensile_strength=5e3),))
    record, rows = checked(find_joints(wall, glue))
    assert record["alpha0"] == pytest.approx((1.25 * 0.5 - 2.5 * 0.125) / (2.5 * 0.25), rel=1e-6)
    assert record["d0_star_m"] is None
    assert len(rows) == 2
    assert all(row["refused"].startswith("once its bond has opened: cannot stand") for row in rows.values())
    _, start = checked(find_joints(wall, glue), limit_state="DL")
    assert start["kinematic, activation", "DL"]["safety_ratio"] > 0.0


def test_an_associative_state_alone_is_refused():
    """H6: without a non-associative state there is nothing to verify."""
    assemblage = rocking()
    analysis = analyse(assemblage)
    alone = replace(analysis, sequence=None, path=None, lowest=None, local_failures=())
    found = loads_in_mechanism(assemblage, LoadSettings(), LimitAnalysisSettings(), alone)
    assert found == UPPER_BOUND
    asked = SeismicSettings(AG)
    record, rows = kinematic_checks(asked, limit_states(asked), found, FORWARD)
    assert record == {"refused": UPPER_BOUND}
    assert rows == [{"approach": "kinematic approach", "limit_state": "all", "refused": UPPER_BOUND}]


def test_slow_stones_of_benchmark_1_no_longer_make_its_participation():
    """H3: e* was 0.352 (a_0* = 0.841 g) of 87 stones, 0.26 to 0.77 by a constant no one sees. alpha_0 is 0.2958."""
    assemblage = case("ferris_tinloi_wall6")
    load = LoadSettings()
    found = loads_in_mechanism(assemblage, load, LimitAnalysisSettings(), answers("ferris_tinloi_wall6"))
    record, (linear, rocks) = kinematic_checks(
        SeismicSettings(AG, confidence_factor=1.0), limit_states(SeismicSettings(AG)), found, FORWARD
    )
    assert record["bodies"] < 10
    assert 0.74 < record["e_star"] < 0.77
    assert record["alpha0"] / record["FC"] == pytest.approx(0.2958, abs=2e-4)
    assert record["a0_star_m_per_s2"] / G == pytest.approx(0.392, abs=2e-3)
    assert linear["safety_ratio_without_e_star"] == pytest.approx(0.754 * linear["safety_ratio"], rel=2e-3)
    assert record["friction_share"] > 0.1
    assert rocks["refused"] == SEVERAL_TURNS


def test_what_slides_and_rocks_at_once_is_not_verified_by_a_balance_of_both():
    """A block of 0.6 m x 1 m with mu = b/h: rocking alone is in balance at b/2 = 0.3 m, a mixture had 0.65 m, and
    passed 0.717 g with the capacity of that."""
    block = find_joints(wall_of(upright(1, 0, 0, 0.6, 1.0), friction=0.6), JointSettings())
    record, rows = checked(block)
    assert record["friction_share"] > 0.1
    assert "is not verified" in rows["kinematic, non-linear", "SD"]["refused"]
    _, rocks = checked(find_joints(replace(block.wall, friction=0.61), JointSettings()))
    assert "refused" not in rocks["kinematic, non-linear", "SD"]


def test_bodies_that_turn_about_each_other_have_no_balance_of_fixed_centres():
    """A portal of two columns of 0.5 m x 2 m and a lintel is in balance when the columns have moved by 0.25 m and the
    lintel by 0.5 m: 0.366 m in the mean, and had 0.676 m."""
    portal = wall_of(upright(1, 0, 0, 0.5, 2), upright(2, 1.5, 0, 0.5, 2), upright(3, 0, 2, 2.0, 0.3), friction=0.7)
    record, rows = checked(find_joints(portal, JointSettings()))
    assert record["d0_star_m"] is None
    assert rows["kinematic, non-linear", "SD"]["refused"] == SEVERAL_TURNS
    assert record["alpha0"] == pytest.approx(0.25)


def test_two_blocks_that_turn_side_by_side_have_the_balance_of_one():
    twins = wall_of(upright(1, 0, 0, WIDTH, 1.0), upright(2, 2, 0, WIDTH, 1.0))
    record, _ = checked(find_joints(twins, JointSettings()))
    assert record["d0_star_m"] == pytest.approx(0.25)


def test_a_small_participation_is_warned_about_and_what_slides_has_no_non_linear_check():
    found = InMechanism("sequence", Kinematics(0.3, 0.5, 8, None, 1.0), ())
    asked = SeismicSettings(AG)
    _, (linear, rocks) = kinematic_checks(asked, limit_states(asked), found, FORWARD)
    said = "e* = 0.5 of 8 bodies is below 0.75: slow bodies count in it, the check is that of e* = 1"
    assert said in linear["remarks"]
    assert rocks == {
        "approach": "kinematic, non-linear", "limit_state": "SD", "refused": NOT_TURNING, "remarks": []
    }  # fmt: skip


@pytest.mark.parametrize("displacement", [None, 0.25], ids=["slides", "turns"])
def test_a_small_participation_raises_no_ratio(displacement):
    """With e* = 0.5 the checks are those of e* = 1; with e* = 0.8 they profit from it."""
    asked = SeismicSettings(AG)

    def rows(participation):
        found = InMechanism("path", Kinematics(0.3, participation, 8, displacement, 0.0), ())
        checks = kinematic_checks(asked, limit_states(asked), found, FORWARD)[1]
        return [row for row in checks if "refused" not in row]

    def start(participation):
        found = InMechanism("path", Kinematics(0.3, participation, 8, displacement, 0.0), ())
        return kinematic_checks(asked, limit_states(asked), found, FORWARD)[0]

    assert (start(0.5)["e_star"], start(0.5)["e_star_used"], start(0.8)["e_star_used"]) == (0.5, 1.0, 0.8)
    assert start(0.5)["a0_star_m_per_s2"] == start(1.0)["a0_star_m_per_s2"] == pytest.approx(0.3 * G / 1.35)
    assert start(0.5)["a0_star_m_per_s2"] == pytest.approx(rows(0.5)[0]["capacity"])
    for low, whole, high in zip(rows(0.5), rows(1.0), rows(0.8), strict=True):
        for key in ("demand", "capacity", "capacity_ag_m_per_s2", "safety_ratio"):
            assert low[key] == pytest.approx(whole[key], rel=1e-6), key
        assert low["safety_ratio"] == low["safety_ratio_without_e_star"]
        assert high["safety_ratio"] > whole["safety_ratio"]
        assert any("the check is that of e* = 1" in text for text in low["remarks"])
    assert len(rows(0.5)) == (1 if displacement is None else 2)


@pytest.mark.parametrize("direction", ["+x", "-x"])
def test_slabs_that_slide_start_at_their_friction(direction):
    """Five of them are at the limit at 0.3 all at once; solvers share the slip out at will (e* was 0.77 to 0.92)."""
    assemblage, load = of_file("tower_slide_5_blocks"), LoadSettings(direction=direction)
    analysis = analyse(assemblage, loads=loads_on(assemblage.wall, load))
    found = loads_in_mechanism(assemblage, load, LimitAnalysisSettings(), analysis).kinematics
    assert found.multiplier == pytest.approx(0.3, rel=1e-6)
    assert found.participation == 1.0
