"""`check` as the first page of a case: sums by hand, and values that are unusual."""

from __future__ import annotations

import json
from dataclasses import replace
from math import cos, inf, radians

import numpy as np
import pytest
from matplotlib.collections import LineCollection, PolyCollection

from orchestrator.app import cli, driver, load_cases
from orchestrator.loads.block_loads import height_of_live_load
from orchestrator.masonry.joints import JointSettings, find_joints
from orchestrator.masonry.wall import Block, Wall
from orchestrator.present import plots, report
from orchestrator.pushover.meshing import MeshSettings
from orchestrator.settings import case as cases
from orchestrator.settings.inventory import class_of_joint, control_words, joint_classes, load_sums, materials
from orchestrator.settings.unusual import unusual
from tests.support.paths import PROJECT

TEMPLATES = PROJECT / "templates"
THICKNESS = 0.4
STONE, TIMBER = 2 * 1.0 * 0.5 * THICKNESS * 20e3, 2.0 * 0.2 * THICKNESS * 6e3
"""two stones of 1.0 x 0.5 m, 20 kN/m3, and a beam of 2.0 x 0.2 m, 6 kN/m3, on both"""
WALL = {
    "name": "blocks",
    "units": {"length": "m", "unit_weight": "kN/m3"},
    "thickness": THICKNESS,
    "unit_weight": 20.0,
    "friction": 0.6,
    "blocks": [
        {"id": 0, "polygon": [[-0.5, -0.2], [2.5, -0.2], [2.5, 0], [-0.5, 0]], "fixed": True},
        {"id": 1, "polygon": [[0, 0], [1, 0], [1, 0.5], [0, 0.5]], "material": "stone"},
        {"id": 2, "polygon": [[1, 0], [2, 0], [2, 0.5], [1, 0.5]], "material": "stone"},
        {"id": 3, "polygon": [[0, 0.5], [2, 0.5], [2, 0.7], [0, 0.7]], "material": "timber"},
    ],
}
CASE = """
[wall]
blocks = "wall.json"
[[wall.classes]]
material = "timber"
unit_weight = "6 kN/m3"
elastic_modulus = "11 GPa"
[[joints.classes]]
between = ["stone", "timber"]
cohesion = "0.2 MPa"
[[load.dead]]
level = "0.7 m"
line_load = "12 kN/m"
inertia = true
[[load.dead]]
blocks = [1, 2]
force = "3 kN"
"""
FLOOR, FORCES = 2.0 * 12e3, 2 * 3e3


@pytest.fixture
def given(tmp_path):
    (tmp_path / "wall.json").write_text(json.dumps(WALL))
    (tmp_path / "case.toml").write_text(CASE)
    return tmp_path / "case.toml"


def checked(case_file, capsys, *settings):
    arguments = [argument for setting in settings for argument in ("--set", setting)]
    assert cli.main(["check", str(case_file), "--output", str(case_file.parent / "look"), *arguments]) == 0
    return capsys.readouterr().out


def read(given, *settings):
    case = cases.read(given, settings)
    return case, load_cases.check(case)


def test_a_floor_without_mass_is_pointed_out_where_a_verification_is_asked_for(given, capsys):
    assert "no mass" not in checked(given, capsys)
    said = "WARNING: 6 kN of dead load have weight, but no mass in the seismic verification"
    assert said in checked(given, capsys, "seismic.peak_ground_acceleration='0.1 g'")


def pointed_out(case, assemblage):
    loads = [load_sums(assemblage.wall, one.load) for one in load_cases.each(case).values()]
    return unusual(case, assemblage.wall, loads, materials(case, assemblage.wall), joint_classes(assemblage))


def test_loads_are_the_sums_by_hand(given):
    case, assemblage = read(given)
    sums = load_sums(assemblage.wall, case.load)
    assert sums.weight == pytest.approx(STONE + TIMBER, rel=1e-12)
    assert [(one.blocks, one.inertia) for one in sums.extra] == [(1, True), (2, False)]
    assert [one.resultant for one in sums.extra] == pytest.approx([FLOOR, FORCES], rel=1e-12)
    assert sums.vertical_load == pytest.approx(STONE + TIMBER + FLOOR + FORCES, rel=1e-12)
    assert sums.horizontal_load == pytest.approx(STONE + TIMBER + FLOOR, rel=1e-12)


@pytest.mark.parametrize(
    ("setting", "base_shear"),
    [
        ("load.inclination=30 deg", cos(radians(30)) * (STONE + TIMBER + FLOOR)),
        ("load.direction=-x", STONE + TIMBER + FLOOR),
        ("load.distribution=mass_height", STONE + TIMBER + FLOOR),
    ],
)
def test_the_base_shear_is_the_horizontal_resultant_of_the_live_load(given, setting, base_shear):
    case, assemblage = read(given, setting)
    assert load_sums(assemblage.wall, case.load).horizontal_load == pytest.approx(base_shear, rel=1e-12)


def test_materials_have_their_own_values_and_the_case_s(given):
    case, assemblage = read(given)
    stone, timber = materials(case, assemblage.wall)
    assert (stone.name, stone.blocks, timber.name, timber.blocks) == ("stone", 2, "timber", 1)
    assert (stone.weight, timber.weight) == pytest.approx((STONE, TIMBER), rel=1e-12)
    assert (stone.area, timber.area) == pytest.approx((1.0, 0.4), rel=1e-12)
    assert (stone.unit_weight, timber.unit_weight) == ((20e3, 20e3), (6e3, 6e3))
    assert (stone.elastic_modulus, timber.elastic_modulus) == ((3.5e9, 3.5e9), (11e9, 11e9))


def test_joints_are_counted_by_materials_and_values(given):
    _, assemblage = read(given)
    found = {one.between: one for one in joint_classes(assemblage)}
    counts = {between: (one.joints, round(one.length, 9), one.cohesion) for between, one in found.items()}
    assert counts == {
        ("stone", "timber"): (2, 2.0, 0.2e6),
        ("stone", "support"): (2, 2.0, 0.0),
        ("stone", "stone"): (1, 0.5, 0.0),
    }
    assert found["stone", "stone"].orientation == "head"
    assert {one.compressive_strength for one in found.values()} == {inf}
    assert sum(one.joints for one in found.values()) == len(class_of_joint(assemblage)) == 5


def test_joints_of_one_pair_with_other_values_are_another_class(given):
    _, assemblage = read(given, "joints.classes=[{orientation='head', friction=0.3}]")
    assert sorted((one.orientation, one.friction, one.joints) for one in joint_classes(assemblage)) == [
        ("bed", 0.6, 2), ("bed", 0.6, 2), ("head", 0.3, 1),
    ]  # fmt: skip


NOTHING_BETWEEN_STONE_AND_TIMBER = "acts on no joint: the wall has no head joint between stone and timber"


@pytest.mark.parametrize(
    ("classes", "said"),
    [
        ("{orientation='head', between=['stone', 'timber'], friction=0.1}", f"0 {NOTHING_BETWEEN_STONE_AND_TIMBER}"),
        (
            "{between=['timber', 'timber'], friction=0.1, cohesion=1e5}",
            "timber; not used: friction, cohesion",
        ),
        ("{orientation='bed'}", "joints.classes.0 acts on no joint: it gives no value"),
        ("{orientation='bed', friction=0.5}, {friction=0.4}", "0: later classes replace it in all its joints"),
        ("{mortar_modulus=1e9, mortar_thickness=0.01}, {normal_stiffness=1e10}", "not used: mortar_modulus"),
    ],
)
def test_a_joint_class_that_acts_on_no_joint_is_told_by_check_and_by_limit_analysis(given, capsys, classes, said):
    setting = f"joints.classes=[{classes}]"
    assert cli.main(["check", str(given), "--set", setting, "--output", str(given.parent / "checked")]) == 0
    assert said in capsys.readouterr().out
    _, analysis = driver.limit(cases.read(given, [setting]))
    assert [said in remark for remark in analysis.remarks].count(True) == 1


@pytest.mark.parametrize(
    "classes",
    [
        "{orientation='head', friction=0.3}",
        "{friction=0.5, cohesion=1e5}, {orientation='bed', friction=0.4, cohesion=2e5}",
        "{friction=0.5}, {orientation='bed', friction=0.4}, {orientation='head', cohesion=1e5}",
    ],
)
def test_a_joint_class_that_acts_on_some_joint_is_not_complained_about(given, classes):
    _, analysis = driver.limit(cases.read(given, [f"joints.classes=[{classes}]"]))
    assert not any("joints.classes" in remark for remark in analysis.remarks)


def test_joints_of_many_stiffnesses_are_one_class_of_each_orientation(given):
    """Drawn mortar has as many thicknesses as joints; what differs by less than its third digit is the same."""
    _, assemblage = read(given)
    count = assemblage.joints.count
    stiffness = np.where(np.arange(count) < count - 1, 20e9 * (1.0 + 1e-9 * np.arange(count)), np.inf)
    alike = replace(assemblage, joints=replace(assemblage.joints, normal_stiffness=stiffness))
    assert len(joint_classes(alike)) <= len(joint_classes(assemblage)) + 1
    wall = rows_of_many(15)
    found = joint_classes(wall)
    assert [(one.orientation, one.joints) for one in found if one.between == ("block", "block")] == [("bed", 14)]
    assert found[0].normal_stiffness == pytest.approx((20e9, 33e9), rel=1e-12)
    assert len({*map(id, class_of_joint(wall))}) == len(found)


def rows_of_many(courses):
    """Courses of one block each on a support, every joint with a stiffness of its own."""
    corners = np.array([[0.0, 0.0], [0.4, 0.0], [0.4, 0.2], [0.0, 0.2]])
    blocks = [Block(k, corners + [0.0, 0.2 * k], k == 0, 20e3) for k in range(courses + 1)]
    assemblage = find_joints(Wall("tower", tuple(blocks), 0.3, 0.6), JointSettings())
    joints = assemblage.joints
    on_block = np.minimum(joints.i, joints.j) > 0
    stiffness = np.where(on_block, 19e9 + 1e9 * np.minimum(joints.i, joints.j), np.inf)
    return replace(assemblage, joints=replace(joints, normal_stiffness=stiffness))


def test_the_first_page_shows_every_sum(given, capsys):
    printed = checked(given, capsys)
    lines = {line.strip() for line in printed.splitlines()}
    for words in (
        ("weight of the blocks", f"{(STONE + TIMBER) / 1e3:.3f}"),
        ("extra: 12 kN/m on level 0.7 m", "24.000", "yes"),
        ("extra: 3 kN each on blocks 1, 2", "6.000", "no"),
        ("all dead load, vertical resultant", f"{(STONE + TIMBER + FLOOR + FORCES) / 1e3:.3f}"),
        ("base shear at λ = 1, +x", f"{(STONE + TIMBER + FLOOR) / 1e3:.3f}"),
        ("stone, timber", "0.2", "none"),
        ("timber", "6", "11"),
    ):
        assert any(all(word in line for word in words) for line in lines), words
    assert "mean of the top edge, y = 0.7 m" in printed
    assert "can balance its dead load" in printed
    assert "3 blocks, 5 joints, nothing to complain about" in printed
    assert (given.parent / "look" / "figures" / "blocks.png").exists()


def test_the_first_page_shows_mortar(given, capsys):
    """E / t and G / t of a class, 5 and 2 N/mm3."""
    mortar = "joints.classes=[{mortar_modulus='50 MPa', mortar_shear_modulus='20 MPa', mortar_thickness='10 mm'}]"
    lines = checked(given, capsys, mortar).splitlines()
    heads = next(line for line in lines if "kn" in line and "ks" in line)
    assert "N/mm3" in lines[lines.index(heads) + 1]
    rows = [line.split() for line in lines if "bed" in line]
    assert rows
    assert all(row[-2:] == ["5", "2"] for row in rows)


@pytest.mark.parametrize(
    ("setting", "said"),
    [
        ("elastic.elastic_modulus=2500", "modulus of stone 2.5e-06 GPa, usual are 0.05 to 220 GPa; is 2500 MPa"),
        ("seismic.peak_ground_acceleration=0.15", "a_g of SD 0.15 m/s2, usual are 0.39 to 9.81 m/s2; is 0.15 g meant?"),
        ("wall.friction=6", "friction of 5 joints 6, usual are 0.2 to 1.5"),
        ("wall.friction=31", "is an angle of 31 degrees meant?"),
        ("wall.unit_weight=19400 kN/m3", "unit weight of stone 1.94e+04 kN/m3, usual are 3 to 32 kN/m3; is 19400 N/m3"),
        ("wall.unit_weight=20", "is 20 kN/m3 meant?"),
        ("load.dead=[{level='0.7 m', line_load=1.2}]", "2.4 N in all, 0.0003 of the wall's weight; is kN meant?"),
        ("mesh.size=100", "mesh.size 100 m is larger than the wall; is 100 mm meant?"),
        ("contact.slip_tolerance=0.9", "0.9 m is larger than a stone of mean size, 0.683 m; is 0.9 mm meant?"),
        ("stepping.final_displacement=20", "20 m is more than the wall's height; is 20 mm meant?"),
        ("stepping.final_displacement=1e-6", "1e-06 m is too little to load a wall of 0.7 m; leave it out"),
        ("wall.thickness=400", "thickness 400 m of a wall of 2 x 0.7 m"),
        ("wall.classes=[]", "timber and stone have the same unit weight and elastic modulus (20 kN/m3, 3.5 GPa)"),
        ("joints.classes=[{compressive_strength=90e3}]", "compressive strength of 5 joints 0.09 MPa"),
        ("joints.classes=[{normal_stiffness=20}]", "normal stiffness of 5 joints 2e-08 N/mm3"),
    ],
)
def test_a_value_of_another_unit_is_pointed_out(given, setting, said):
    found = pointed_out(*read(given, setting))
    assert any(line.startswith("UNUSUAL: ") and said in line for line in found), found


@pytest.mark.parametrize("template", ["arched_facade", "benchmark1", "benchmark2"])
def test_the_shipped_walls_are_not_unusual(template):
    case, assemblage = read(TEMPLATES / f"{template}.toml")
    assert pointed_out(case, assemblage) == []
    assert pointed_out(replace(case, mesh=MeshSettings(size=100.0)), assemblage) != []


def test_the_first_page_points_out_what_is_unusual(given, capsys):
    printed = checked(given, capsys, "wall.friction=1.6")
    assert "case.toml: UNUSUAL: friction of 5 joints 1.6, usual are 0.2 to 1.5" in printed
    assert "see the warnings above" in printed


def test_the_control_point_of_n2_is_told_where_a_verification_is_asked(given):
    said = control_words(*read(given))
    assert len(said) == 1
    asked = ["seismic.peak_ground_acceleration=0.15 g"]
    assert "of: floor at y = 0.7 m, 1 block" in control_words(*read(given, *asked))[1]
    named = control_words(*read(given, *asked, "seismic.control_blocks=[2]"))
    assert named[1] == "control point of N2: top of block 2"


def test_the_picture_shows_loads_classes_and_supports(given):
    case, assemblage = read(given)
    words = [f"cohesion {one.cohesion:g}" for one in class_of_joint(assemblage)]
    axes = plots.given(assemblage, case.load, words).axes[0]
    labels = axes.get_legend_handles_labels()[1]
    arrow = next(one for one in axes.texts if one.arrow_patch is not None)
    middle = 0.5 * (arrow.xy[1] + arrow.xyann[1])
    assert middle == pytest.approx(height_of_live_load(assemblage.wall, case.load))
    assert {"support", "cohesion 200000"} <= {*labels}
    loads = [label.rpartition(": ")[2] for label in labels if label.startswith("dead load, ")]
    assert loads == ["24.000 kN, with its mass", "6.000 kN"]
    lines = [line for line in axes.collections if isinstance(line, LineCollection)]
    drawn = {line.get_label().rpartition(": ")[2]: line for line in lines}
    arrows = np.array(drawn["6.000 kN"].get_segments())
    tips = {tuple(np.round(tip, 6)) for tip in arrows[:, 1]}
    assert tips == {(0.5, 0.25), (1.5, 0.25)}, "forces act at centroids"
    assert np.allclose(np.array(drawn["24.000 kN, with its mass"].get_segments())[:, 1, 1], 0.7), "on the top"
    bonded = np.array(drawn["cohesion 200000"].get_segments())
    assert np.allclose(bonded[..., 1], 0.5)
    assert sum(len(one.get_paths()) for one in axes.collections if isinstance(one, PolyCollection)) == 4
    assert [text.get_text() for text in axes.texts if text.get_text().isdigit()] == ["0", "1", "2", "3"]


def test_live_loads_on_blocks_are_listed_and_drawn_as_large_as_they_are(given, capsys):
    given.write_text(
        CASE.replace("[[load.dead]]", '[load]\ndistribution = "per_block"\n[[load.dead]]', 1)
        + '[[load.live]]\nblocks = [1, 2]\nforce = "4 kN"\n[[load.live]]\nblocks = [3]\nforce = "-2 kN"\n'
    )
    lines = [" ".join(line.split()) for line in checked(given, capsys).splitlines()]
    assert "live at λ = 1: 4 kN each on blocks 1, 2 2 8.000" in lines
    assert "live at λ = 1: -2 kN on block 3 1 -2.000" in lines
    case, assemblage = read(given)
    axes = plots.given(assemblage, case.load, []).axes[0]
    drawn = next(one for one in axes.collections if str(one.get_label()).startswith("live load on blocks, largest 4"))
    tails, tips = np.swapaxes(drawn.get_segments()[:3], 0, 1)
    np.testing.assert_allclose(tips, [[0.5, 0.25], [1.5, 0.25], [1.0, 0.6]])
    along = tips - tails
    np.testing.assert_allclose(along / along[0, 0], [[1.0, 0.0], [1.0, 0.0], [-0.5, 0.0]], atol=1e-12)


def test_materials_whose_joints_have_the_same_values_paint_no_joint(given, monkeypatch, tmp_path):
    drawn = []
    monkeypatch.setattr(plots, "given", lambda assemblage, load, words, ties: drawn.append(words))
    monkeypatch.setattr(plots, "save", lambda *_: [tmp_path])
    for settings in ([], ["joints.classes=[]", "wall.classes=[]"]):
        case, assemblage = read(given, *settings)
        report.write_given(tmp_path, case, assemblage)
    assert len({*drawn[0]}) > 1
    assert drawn[1] == []


def test_joints_of_one_class_are_not_painted(given):
    case = cases.read(given, ["joints.classes=[]", "load.dead=[]"])
    axes = plots.given(find_joints(cases.read_wall(case), case.joints), case.load, ["plain"] * 5).axes[0]
    assert "plain" not in axes.get_legend_handles_labels()[1]


def test_every_load_case_has_its_own_sums_and_picture(given, capsys):
    several = "load.cases=[{name='right'}, {name='left', direction='-x', dead=[{blocks=[3], force='1 kN'}]}]"
    printed = checked(given, capsys, several)
    assert "2 load cases" in printed
    dead = STONE + TIMBER + FLOOR + FORCES
    for name, total in (("right", dead), ("left", dead + 1e3)):
        assert f"Loads, {name}" in printed
        assert f"{total / 1e3:.3f}" in printed
        assert (given.parent / "look" / "figures" / f"blocks_{name}.png").exists()
