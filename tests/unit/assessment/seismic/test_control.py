"""Control point: named, by level, or the roof or floor that moves most; what cannot be named is refused."""

from __future__ import annotations

from dataclasses import replace

import pytest

from orchestrator.app.cli import main
from orchestrator.assessment.seismic.control import candidates, control_point, named_point, uncovered
from orchestrator.assessment.seismic.local_mechanism import loads_in_mechanism, safest_state
from orchestrator.assessment.seismic.settings import SeismicSettings
from orchestrator.basis.errors import CaseError
from orchestrator.limit_analysis import LimitAnalysisSettings, analyse
from orchestrator.loads import DeadLoad, LoadSettings, loads_on
from orchestrator.masonry.joints import JointSettings, find_joints
from tests.support.walls import upright
from tests.unit.assessment.seismic.test_kinematic_checks import wall_of

PARAMETERS = "spectrum = 'parameters'\nsoil_factor = 1.2\nperiod_b = '0.1 s'\nperiod_c = '0.5 s'\nperiod_d = '2 s'\n"


def two_towers(width=0.1):
    """K4: a slender tower, six times as high as wide, that topples first, and a squat one of 1 m x 2 m beside it, in
    two courses."""
    slender = upright(1, 0, 0, width, 6 * width)
    return find_joints(wall_of(slender, upright(2, 2, 0, 1, 1), upright(3, 2, 1, 1, 1)), JointSettings())


def chosen(assemblage, load=None, **settings):
    load = load or LoadSettings()
    analysis = analyse(assemblage, loads=loads_on(assemblage.wall, load))
    return control_point(SeismicSettings(1.0, **settings), assemblage, load, analysis)


@pytest.mark.parametrize("direction", ["+x", "-x"])
def test_the_slender_tower_is_watched_not_the_higher_one(direction):
    """It is 12 % of the weight: more than a local failure."""
    point = chosen(two_towers(0.2), LoadSettings(direction=direction))
    assert point.name == "roof at y = 1.2 m, 1 block"
    assert point.blocks == (1,)


@pytest.mark.parametrize("direction", ["+x", "-x"])
def test_a_tower_that_falls_as_a_local_failure_is_not_watched(direction):
    """It is 2.9 % of the weight: the curve goes on without it."""
    assert chosen(two_towers(), LoadSettings(direction=direction)).name == "roof at y = 2 m, 1 block"


def test_what_a_loose_stone_covered_is_a_roof_once_it_has_gone():
    wall = wall_of(upright(1, 0, 0, 1, 1), upright(2, 0.2, 1, 0.6, 0.2))
    assemblage = find_joints(wall, JointSettings())
    assert uncovered(assemblage).tolist() == [2]
    assert uncovered(assemblage, gone=frozenset({2})).tolist() == [1]


def test_the_sill_of_a_window_is_no_roof():
    piers = upright(1, 0, 0, 0.5, 2), upright(2, 1.5, 0, 0.5, 2)
    wall = wall_of(*piers, upright(3, 0.5, 0, 1, 0.8), upright(4, 0, 2, 2, 0.3))
    assert uncovered(find_joints(wall, JointSettings())).tolist() == [4]


@pytest.mark.parametrize("length", [0.3, 0.5, 0.7])
def test_each_step_of_a_raked_end_is_a_roof(length):
    """Half of the last stone of each course is covered; rounding decided."""
    places = [(course, number) for course in range(3) for number in range(3 - course)]
    stones = [upright(k + 1, (0.5 * c + n) * length, 0.2 * c, length, 0.2) for k, (c, n) in enumerate(places)]
    wall = wall_of(*stones)
    roofs = uncovered(find_joints(wall, JointSettings()))
    assert {round(float(wall.blocks[k].polygon[:, 1].max()), 3) for k in roofs} == {0.2, 0.4, 0.6}


def test_stones_that_come_loose_first_are_verified_not_the_wall_without_them():
    """The slender tower is 2.9 % of the weight, a local failure at 0.1 / 0.6; the squat one tips at 1 / 2."""
    assemblage = two_towers()
    analysis = analyse(assemblage)
    assert analysis.headline.load_multiplier == pytest.approx(0.5, rel=1e-6)
    found = loads_in_mechanism(assemblage, LoadSettings(), LimitAnalysisSettings(), analysis)
    assert found.kinematics.multiplier == pytest.approx(1 / 6, rel=1e-6)
    assert found.kinematics.bodies == 1
    assert "stone 1 (2.9 % of the dead load) moves, not the wall" in found.remarks[0]


def test_a_last_rest_is_not_passed_over_for_a_higher_state():
    analysis = analyse(two_towers(), LimitAnalysisSettings(local_share=0.0))
    rest = replace(analysis.path, load_multiplier=0.1, converged=False)
    known = replace(analysis, path=rest, lowest=replace(analysis.path, load_multiplier=0.4), sequence=None)
    assert safest_state(known) is rest
    assert safest_state(replace(known, lowest=replace(analysis.path, load_multiplier=0.05))).load_multiplier == 0.05


def test_roofs_are_tops_that_nothing_covers_and_floors_are_what_carries_loads():
    assemblage = two_towers()
    assert uncovered(assemblage).tolist() == [1, 3]
    load = LoadSettings(dead=(DeadLoad(level=1.0, line_load=5e3, inertia=True),))
    assert [point.name for point in candidates(assemblage, load)] == [
        "floor at y = 1 m, 1 block",
        "roof at y = 0.6 m, 1 block",
        "roof at y = 2 m, 1 block",
    ]


def test_one_stone_that_stands_1_mm_above_the_rest_is_not_alone():
    """K4: tops within 2 mm are one roof."""
    wall = wall_of(upright(1, 0, 0, 1, 1), upright(2, 1, 0, 1, 1.001))
    (point,) = candidates(find_joints(wall, JointSettings()), LoadSettings())
    assert point.blocks == (1, 2)


@pytest.mark.parametrize("scale", [0.002, 1.0])
def test_two_roofs_are_two_at_every_size(scale):
    """Tops within a part of a stone's height are one roof. They were within 10 mm, one after the other."""
    steps = [upright(k, 2.0 * k * scale, 0, scale, (1 + 0.008 * k) * scale) for k in range(1, 4)]
    wall = wall_of(*steps, upright(4, 8 * scale, 0, scale, 2 * scale))
    found = candidates(find_joints(wall, JointSettings(tolerance=1e-4 * scale)), LoadSettings())
    assert [point.blocks for point in found] == [(1, 2), (3,), (4,)]


def test_named_points():
    assert chosen(two_towers(), control_blocks=(3,)).name == "top of block 3"
    assert chosen(two_towers(), control_level=1.0).blocks == (2,)


@pytest.mark.parametrize(
    ("settings", "key", "said"),
    [
        ({"control_blocks": (9,)}, "seismic.control_blocks", "no block 9"),
        ({"control_blocks": (0,)}, "seismic.control_blocks", "no block 0 that can move"),
        ({"control_level": 1.5}, "seismic.control_level", "tops are at 0.6, 1, 2 m"),
        ({"control_level": 1.0, "control_blocks": (1,)}, "seismic.control_level", "one of the two"),
    ],
)
def test_what_is_not_there_is_refused(settings, key, said):
    with pytest.raises(CaseError, match=said) as caught:
        named_point(SeismicSettings(1.0, **settings), two_towers().wall)
    assert caught.value.key == key


@pytest.mark.parametrize("command", ["check", "run"])
@pytest.mark.parametrize(
    ("lines", "said"),
    [
        (
            "spectrum = 'ntc2018'\nreference_period = '0.3 s'\nsoil_factor = 1.5",
            "seismic.soil_factor: the spectrum 'ntc2018' does not read it; leave it out, or give "
            "spectrum = 'parameters', which reads it",
        ),
        (
            "amplification = 2.4",
            "seismic.amplification: the spectrum 'ec8_type1' does not read it; leave it out, or give",
        ),
        ("soil_factor = 1.5", "seismic.soil_factor: the spectrum 'ec8_type1' does not read it"),
        ("reference_period = '0.3 s'", "seismic.reference_period: the spectrum 'ec8_type1' does not read it"),
        (
            f"{PARAMETERS}ground = 'B'",
            "seismic.ground: the spectrum 'parameters' does not read it; leave it out, or give",
        ),
        (f"{PARAMETERS}topography = 1.4", "seismic.topography: the spectrum 'parameters' does not read it"),
        (
            "[[seismic.limit_states]]\nname = 'NC'\npeak_ground_acceleration = '0.2 g'\namplification = 2.4",
            "seismic.limit_states.0.amplification: the spectrum 'ec8_type1' does not read it",
        ),
        (PARAMETERS.replace("0.1 s", "0.9 s"), "seismic.period_c: the periods do not rise; give period_b <= period_c"),
        ("control_blocks = [1, 1]", "seismic.control_blocks: names block 1 more than once; name every block once"),
        (
            "limit_state = 'SLV'",
            "seismic.limit_state: SLV is no limit state of the spectrum 'ec8_type1'; use one of DL",
        ),
        ("limit_state = 'SLU'", "seismic.limit_state: 'SLU' is not accepted"),
        ("spectrum = 'ntc2018'", "seismic.reference_period: is missing for the spectrum 'ntc2018'; give it, as in"),
        ("control_level = '9 m'", "seismic.control_level: no block has its top at 9 m; tops are at 1 m"),
        ("control_blocks = [77]", "seismic.control_blocks: there is no block 77 that can move; name blocks"),
        ("mechanism_height = '3 m'", "seismic.building_height: is missing for a wall at 3 m above the ground; give it"),
        ("[[seismic.limit_states]]\nname = 'NC'", "seismic.limit_states.0.peak_ground_acceleration: is missing"),
        (
            "[[seismic.limit_states]]\nname = 'NC'\npeak_ground_acceleration = '2 kN'",
            "seismic.limit_states.0.peak_ground_acceleration: unit 'kN' does not fit; use one of m/s2, g",
        ),
    ],
)
def test_bad_settings_are_one_line_and_exit_code_2(command, lines, said, tmp_path, capsys):
    """`check` refuses what `run` would, and a setting of another spectrum is not dropped in silence."""
    (tmp_path / "block.json").write_text(
        '{"name": "b", "units": {"length": "m", "unit_weight": "kN/m3"}, "thickness": 1, "unit_weight": 20,'
        ' "friction": 0.6, "blocks": [{"id": 0, "polygon": [[-1, -1], [2, -1], [2, 0], [-1, 0]], "fixed": true},'
        ' {"id": 1, "polygon": [[0, 0], [0.5, 0], [0.5, 1], [0, 1]]}]}',
        encoding="utf-8",
    )
    case = tmp_path / "case.toml"
    case.write_text(f"[wall]\nblocks = 'block.json'\n[seismic]\npeak_ground_acceleration = '0.1 g'\n{lines}\n", "utf-8")
    assert main([command, str(case), "--output", str(tmp_path / "out")]) == 2
    captured = capsys.readouterr()
    assert captured.err.count("\n") == 1
    assert f"{case}: {said}" in captured.err
    assert not (tmp_path / "out").exists()
