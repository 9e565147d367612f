from __future__ import annotations

import json
import math
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from orchestrator.app import driver
from orchestrator.basis.checked import Checked
from orchestrator.basis.errors import CaseError
from orchestrator.limit_analysis import LimitAnalysisSettings
from orchestrator.loads import DeadLoad, LoadSettings
from orchestrator.macroblocks.criteria import MacroblockSettings
from orchestrator.masonry.joints import JointClass
from orchestrator.masonry.sources.block_files import read_blocks
from orchestrator.masonry.ties import Tie
from orchestrator.pushover.meshing import MeshSettings
from orchestrator.pushover.settings import ContactSettings, ElasticSettings, NewtonSettings, SteppingSettings
from orchestrator.settings import case as cases
from tests.support.paths import DATA, PROJECT

BENCHMARK = PROJECT / "templates" / "benchmark1.toml"
WALL = DATA / "tower_5_blocks.json"


def test_benchmark_1_is_what_the_paper_ran():
    case = cases.read(BENCHMARK)
    assert case.macroblocks.tol_n == 1e-3
    assert case.macroblocks.tol_d == pytest.approx(0.45)
    assert math.isinf(case.macroblocks.tol_s)
    assert case.elastic.elastic_modulus == pytest.approx(3.5e9)
    assert case.load.vector.tolist() == [1.0, 0.0]
    wall = cases.read_wall(case)
    assert (wall.thickness, wall.friction) == (pytest.approx(0.1), pytest.approx(0.65))
    assert {block.unit_weight for block in wall.blocks} == {25e3}


def test_a_block_file_is_a_case_with_every_default():
    case = cases.read(WALL)
    assert case == cases.Case(cases.WallSettings("tower_5_blocks.json"), name="tower_5_blocks")
    assert case.block_file == WALL


def test_paths_may_be_text():
    assert cases.read(str(WALL)) == cases.read(WALL)
    assert len(read_blocks(str(WALL)).blocks) == len(read_blocks(WALL).blocks)


def test_overrides_take_units_lists_and_words():
    case = cases.read(WALL, ["mesh.size=50mm", "run.models=['micro']", "load.direction=-x", "wall.friction=0.4"])
    assert case.mesh.size == pytest.approx(0.05)
    assert case.run.models == ("micro",)
    assert case.load.vector.tolist() == [-1.0, 0.0]
    assert cases.read_wall(case).friction == pytest.approx(0.4)


def test_wall_section_replaces_the_block_file_s_values():
    wall = cases.read_wall(cases.read(WALL, ["wall.thickness=30cm", "wall.unit_weight=18 kN/m3"]))
    assert wall.thickness == pytest.approx(0.3)
    assert {block.unit_weight for block in wall.blocks} == {18e3}


def test_written_case_reads_back_equal(tmp_path):
    case = cases.read(BENCHMARK, ["mesh.size=123mm", "stepping.final_displacement=7mm"])
    written = tmp_path / "case.toml"
    written.write_text(cases.as_toml(case, "blocks.json"))
    read = cases.read(written)
    assert replace(read, wall=case.wall) == case
    assert read.wall.blocks == "blocks.json"
    assert 'size = "0.123 m"' in written.read_text()


def test_lists_of_tables_are_read_with_units_and_written_back(tmp_path):
    (tmp_path / "case.toml").write_text(
        "[wall]\nblocks = 'tower.json'\n"
        "[load]\ninclination = '-30 deg'\n"
        "[[load.dead]]\nblocks = [1, 2]\nforce = '5 kN'\n"
        "[[load.dead]]\nblocks = [3]\nline_load = '2 kN/m'\ninertia = true\n"
        "[[joints.classes]]\norientation = 'bed'\nbetween = ['a', 'b']\ncohesion = '0.1 MPa'\nfriction = 0.5\n"
    )
    case = cases.read(tmp_path / "case.toml")
    assert case.load.inclination == pytest.approx(-math.pi / 6)
    assert case.load.dead == (DeadLoad((1, 2), force=5e3), DeadLoad((3,), line_load=2e3, inertia=True))
    assert case.joints.classes == (JointClass("bed", ("a", "b"), friction=0.5, cohesion=1e5),)
    (tmp_path / "written.toml").write_text(cases.as_toml(case, "tower.json"))
    again = cases.read(tmp_path / "written.toml")
    assert (again.load, again.joints) == (case.load, case.joints)


def test_the_pushover_refuses_a_load_without_base_shear(tmp_path):
    case = cases.read(BENCHMARK, ["load.inclination=-90 deg"])
    with pytest.raises(CaseError, match=r"benchmark1\.toml: load\.inclination: an upright live load has no base"):
        driver.run(case, tmp_path / "out", False, None, lambda _: None)
    assert not (tmp_path / "out").exists()


@pytest.mark.parametrize("path", ["mesh", "mesh.size", "=3", ".size=1", "mesh.=1", "..=1", "mesh.size.x=1"])
def test_an_override_must_name_a_section_and_a_key(path):
    with pytest.raises(
        CaseError, match=r"--set: .* is not of the form section\.key=value; as in --set mesh\.size=100mm"
    ):
        cases.read(WALL, [path])


@pytest.mark.parametrize(
    ("override", "complaint"),
    [
        ("mesh.size=" + "[" * 5000, "mesh.size: .* is not a quantity; write a number and its unit"),
        ("mesh.siz=1", "mesh.siz: is not a known key; did you mean size"),
        ("macroblocks.normal=1e-3", "macroblocks.normal: has another name since version 0.2; write tol_n"),
        ("study.centre_distance=[1]", "study.centre_distance: has another name since version 0.2; write tol_d"),
        ("mesh.size=3 kN", "mesh.size: unit 'kN' does not fit; use one of m, mm, cm, km, in, ft"),
        ("wall=3", "wall: 3 is not accepted; it is a section"),
        ("seismic.peak_ground_acceleration=-0.1 g", "seismic.peak_ground_acceleration: -0.981 m/s2 is not accepted"),
        ("mesh.size=inf", "mesh.size: inf is not a finite number"),
        ("mesh.size=none", "mesh.size: 'none' is not a quantity"),
        ("wall.friction=0.6 m", "wall.friction: '0.6 m' is not a number; write a number without unit"),
        ("wall.friction=true", "wall.friction: True is not a number"),
        ("wall.blocks.x=1", "--set: "),
        ("elastic.element_order=true", "elastic.element_order: True is not a whole number"),
        ("elastic.element_order=3", "elastic.element_order: 3 is not accepted; write at most 2"),
        ("limit_analysis.tolerance=1e300", r"limit_analysis.tolerance: 1e\+300 is not accepted; .* less than 1"),
        ("limit_analysis.power_tolerance=1", "limit_analysis.power_tolerance: 1 is not accepted; .* less than 1"),
        (
            "limit_analysis.maximum_iterations=3",
            "limit_analysis.minimum_iterations: 4 is more than maximum_iterations, 3; give at most as many",
        ),
        ("run.models=['macro', 'micro', 'macro']", "run.models: has 'macro' twice; give every value once"),
        ("study.tol_n=[1e-3, inf, 0.001]", "study.tol_n: has 0.001 twice; give every value once"),
        ("study.tol_d=['0.45 m', 'none', '450 mm', 'none']", "study.tol_d: has 0.45 twice; give every value once"),
        ("sensitivity.friction=[0.7, 0.5]", r"sensitivity.friction: \[0.7, 0.5\] is no range; write \[low, high\]"),
    ],
)
def test_a_wrong_override_is_refused_like_a_wrong_key(override, complaint):
    with pytest.raises(CaseError, match=r"tower_5_blocks\.json: " + complaint):
        cases.read(WALL, [override])


def test_tolerances_of_the_macroblocks_may_be_switched_off():
    case = cases.read(WALL, ["macroblocks.tol_s=inf", "macroblocks.tol_r=none", "macroblocks.tol_n=0.002"])
    assert (case.macroblocks.tol_s, case.macroblocks.tol_r) == (math.inf, math.inf)
    assert case.macroblocks.tol_n == 0.002


def test_blocks_are_found_beside_the_case_file(tmp_path, monkeypatch):
    (tmp_path / "walls").mkdir()
    (tmp_path / "walls" / "Tower.JSON").write_text(WALL.read_text())
    (tmp_path / "walls" / "case.toml").write_text("name = 'tower'\n[wall]\nblocks = 'Tower.JSON'")
    monkeypatch.chdir(tmp_path)
    case = cases.read(Path("walls/case.toml"))
    expected_name = json.loads(WALL.read_text())["name"]
    assert expected_name != "tower"
    assert case.name == cases.read_wall(case).name == "tower", "pictures and report have the name of the case"
    assert cases.read_wall(cases.read(Path("walls/Tower.JSON"))).name == expected_name
    expected = cases.read_wall(cases.read(WALL))
    for wall in (cases.read_wall(case), cases.read_wall(cases.read(Path("walls/Tower.JSON")))):
        assert len(wall.blocks) == 6
        assert [b.polygon.tolist() for b in wall.blocks] == [b.polygon.tolist() for b in expected.blocks]


def test_the_wall_of_a_path_is_asked_for_by_its_case():
    with pytest.raises(
        CaseError, match=r"case: PosixPath was given, Case is expected; write read_wall\(read_case\(path"
    ):
        cases.read_wall(WALL)


def test_a_path_that_no_output_file_can_hold_is_refused():
    with pytest.raises(CaseError, match=r"caf.udce9\.json' is not UTF-8; rename it"):
        cases.read(Path("caf\udce9.json"))


VALUES = st.recursive(
    st.none() | st.booleans() | st.integers() | st.floats() | st.text(max_size=8),
    lambda children: st.lists(children, max_size=3) | st.dictionaries(st.text(max_size=6), children, max_size=3),
    max_leaves=6,
)
SECTIONS = st.sampled_from(["wall", "mesh", "macroblocks", "stepping", "run", "limit_analysis", "load", "name", "x"])
KEYS = st.sampled_from(["blocks", "size", "layers", "normal", "models", "seed_cohesions", "direction", "friction", "y"])


@settings(max_examples=200, deadline=None)
@given(st.dictionaries(SECTIONS, st.dictionaries(KEYS, VALUES, max_size=3) | VALUES, max_size=3))
def test_no_record_gets_further_than_a_case_error(record):
    said = ""
    try:
        assert isinstance(cases._case(record).wall.blocks, str)
    except CaseError as error:
        said = str(error)
    assert "\n" not in said


CLASSES = """
[wall]
blocks = "door.json"
friction = 0.5
[[wall.classes]]
material = "timber"
unit_weight = "6 kN/m3"
thickness = "20 cm"
friction = 0.4
elastic_modulus = "11 GPa"
poisson_ratio = 0.3
"""


def door(folder):
    ground = {"id": 0, "polygon": [[-1, -1], [3, -1], [3, 0], [-1, 0]], "fixed": True}
    jamb = {"id": 1, "polygon": [[0, 0], [1, 0], [1, 1], [0, 1]], "material": "stone"}
    lintel = {"id": 2, "polygon": [[0, 1], [1, 1], [1, 2], [0, 2]], "material": "timber"}
    units = {"length": "m", "unit_weight": "kN/m3"}
    wall = {"units": units, "thickness": 0.3, "unit_weight": 20, "friction": 0.7, "blocks": [ground, jamb, lintel]}
    (folder / "door.json").write_text(json.dumps(wall))
    return folder / "door.toml"


def test_block_classes_change_the_blocks_of_their_material_and_are_written_back(tmp_path):
    door(tmp_path).write_text(CLASSES)
    case = cases.read(tmp_path / "door.toml")
    _, jamb, lintel = cases.read_wall(case).blocks
    assert (jamb.unit_weight, jamb.thickness, jamb.friction, jamb.elastic_modulus) == (20e3, None, None, None)
    found = (lintel.unit_weight, lintel.thickness, lintel.friction, lintel.elastic_modulus, lintel.poisson_ratio)
    assert found == pytest.approx((6e3, 0.2, 0.4, 11e9, 0.3))
    assert driver.check(case).joints.friction == pytest.approx([0.5, 0.4])
    (tmp_path / "written.toml").write_text(cases.as_toml(case, "door.json"))
    assert cases.read(tmp_path / "written.toml").wall.classes == case.wall.classes


@pytest.mark.parametrize(
    ("old", "new", "complaint"),
    [
        ('"timber"', '"timbre"', "wall.classes.0.material: no block is of 'timbre'; materials are stone, timber"),
        ('"timber"', '""', "wall.classes.0.material: '' is not accepted; write a text that is not empty"),
        ("unit_weight", "unit_wieght", "wall.classes.0.unit_wieght: is not a known key; did you mean unit_weight?"),
        ('"20 cm"', '"0 cm"', "wall.classes.0.thickness: 0 m is not accepted; write at least 1e-09 m"),
        ('"11 GPa"', '"11 kN"', "wall.classes.0.elastic_modulus: unit 'kN' does not fit; use one of Pa"),
        ("poisson_ratio = 0.3", "poisson_ratio = 0.5", "wall.classes.0.poisson_ratio: 0.5 is not accepted"),
    ],
)
def test_block_classes_that_cannot_be(tmp_path, old, new, complaint):
    door(tmp_path).write_text(CLASSES.replace(old, new))
    with pytest.raises(CaseError) as raised:
        cases.read_wall(cases.read(tmp_path / "door.toml"))
    assert f"door.toml: {complaint}" in str(raised.value)


@pytest.mark.parametrize(
    ("setting", "missing", "table"),
    [
        ("mesh.size='100 mm'", "wall", "[wall]"),
        ("wall.friction=0.6", "wall.blocks", "[wall]"),
        ("wall.classes=[{friction=0.4}]", "wall.classes.0.material", "[[wall.classes]]"),
        ("reinforcement.ties=[{blocks=[1], start=[0, 1], end=[0, 2]}]", "ties.0.strength", "[[reinforcement.ties]]"),
        ("seismic.limit_states=[{name='SLC'}]", "peak_ground_acceleration", "[[seismic.limit_states]]"),
    ],
)
def test_what_is_missing_is_shown_by_the_file_that_is_named(tmp_path, setting, missing, table):
    given = "" if missing in ("wall", "wall.blocks") else '[wall]\nblocks = "wall.json"\n'
    (tmp_path / "case.toml").write_text(given)
    with pytest.raises(CaseError) as raised:
        cases.read(tmp_path / "case.toml", [setting])
    assert f"{missing}: is missing; see " in str(raised.value)
    example = raised.value.remedy.removeprefix("see ").removesuffix(" for an example")
    assert table in (PROJECT / example).read_text(encoding="utf-8")


def test_a_misspelt_section_is_named_before_the_section_that_it_leaves_missing(tmp_path):
    path = tmp_path / "wall.toml"
    path.write_text('[wal]\nblocks = "wall.json"\n')
    with pytest.raises(CaseError, match=r"wal: is not a known key; did you mean wall\?"):
        cases.read(path)


SETTINGS_IN_PYTHON = [
    (
        lambda: LoadSettings(direction="+X"),
        "direction: '+X' is not accepted; input should be '+x' or '-x'",
    ),
    (lambda: LoadSettings(direction="left"), "LoadSettings.direction: 'left' is not accepted"),
    (lambda: LoadSettings(distribution="foo"), "LoadSettings.distribution: 'foo' is not accepted"),
    (lambda: LoadSettings(inclination=math.nan), "LoadSettings.inclination: nan is not a number; write a finite one"),
    (lambda: LoadSettings(dead=(1.0,)), "LoadSettings.dead.0: 1.0 is not accepted"),
    (lambda: replace(LoadSettings(), direction="y"), "LoadSettings.direction: 'y' is not accepted"),
    (lambda: DeadLoad(blocks=(1,), line_load=math.nan), "DeadLoad.line_load: nan is not a number"),
    (lambda: ElasticSettings(poisson_ratio=0.6), "ElasticSettings.poisson_ratio: 0.6 is not accepted; write less"),
    (lambda: LimitAnalysisSettings(relaxation=-1), "LimitAnalysisSettings.relaxation: -1 is not accepted"),
    (lambda: LimitAnalysisSettings(seed_cohesions=()), "seed_cohesions: () is not accepted; write a list of at least"),
    (lambda: MacroblockSettings(choose="foo"), "MacroblockSettings.choose: 'foo' is not accepted"),
    (lambda: MacroblockSettings(tol_n=-1), "MacroblockSettings.tol_n: -1 is not accepted"),
    (lambda: MeshSettings(size=-1), "MeshSettings.size: -1 m is not accepted; write at least"),
    (lambda: MeshSettings(size="fine"), "MeshSettings.size: 'fine' is not a quantity; write a number and its unit"),
    (lambda: ContactSettings(slip_tolerance=0), "ContactSettings.slip_tolerance: 0 m is not accepted"),
    (lambda: NewtonSettings(iterations=10**400), "NewtonSettings.iterations: 1000000000"),
    (lambda: SteppingSettings(load_increment=1.0000000000001), "1.0000000000001 is not accepted; write at most 1"),
    (lambda: NewtonSettings(iterations=20.5), "NewtonSettings.iterations: 20.5 is not a whole number"),
    (lambda: NewtonSettings(iterations=True), "NewtonSettings.iterations: True is not a whole number"),
    (lambda: SteppingSettings(final_displacement=-0.02), "SteppingSettings.final_displacement: -20 mm is not accepted"),
    (lambda: JointClass(friction="0.6"), "JointClass.friction: '0.6' is not a number; write a number without unit"),
    (lambda: Tie((1, 2), ("0 m", "1 m"), (2.0, 1.0), strength=-1), "Tie.strength: -1 N is not accepted"),
    (lambda: Tie((1,), (0.0, 1.0), (0.0,), 1e3), "Tie.end: (0.0,) is not accepted; write a list of at least 2"),
]


@pytest.mark.parametrize(("made", "complaint"), SETTINGS_IN_PYTHON)
def test_settings_made_in_python_have_the_limits_of_a_case_file(made, complaint):
    with pytest.raises(CaseError) as raised:
        made()
    assert complaint in str(raised.value)


def test_settings_made_in_python_take_units_and_what_numpy_counts():
    assert MeshSettings(size="25 mm") == MeshSettings(size=0.025)
    load = DeadLoad(blocks=np.array([3, 4]), line_load=np.float32(5e3))
    assert (load.blocks, load.line_load) == ((3, 4), 5e3)
    assert [type(block) for block in load.blocks] == [int, int]
    assert MacroblockSettings(tol_d="none").tol_d == math.inf


def test_every_section_of_a_case_file_has_its_limits_in_python():
    kinds = cases.section_types() | cases.table_types()
    assert [name for name, kind in kinds.items() if not issubclass(kind, Checked)] == []
