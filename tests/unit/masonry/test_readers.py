from __future__ import annotations

import json

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from orchestrator.basis.errors import CaseError
from orchestrator.masonry.patterns import running_bond
from orchestrator.masonry.sources.block_files import polygon_of, read_blocks, wall_from
from orchestrator.masonry.wall import check_wall


def record(**changes):
    ground = {"id": 7, "polygon": [[-1000, -200], [-1000, 0], [2000, 0], [2000, -200]], "fixed": True}
    stone = {"id": 9, "polygon": [[0, 0], [500, 0], [500, 300], [0, 300], [0, 0]], "unit_weight": 30}
    units = {"length": "mm", "unit_weight": "kN/m3"}
    wall = {"units": units, "thickness": 250, "unit_weight": 20, "friction": 0.7, "blocks": [ground, stone]}
    return wall | changes


def test_units_orientation_closing_corner_and_own_weight():
    wall = wall_from(record(), "stem")
    check_wall(wall)
    ground, stone = wall.blocks
    assert wall.name == "stem"
    assert wall.thickness == pytest.approx(0.25)
    assert (ground.id, ground.fixed, ground.unit_weight) == (7, True, 20e3)
    assert (stone.id, stone.fixed, stone.unit_weight) == (9, False, 30e3)
    assert stone.polygon == pytest.approx(np.array([[0, 0], [0.5, 0], [0.5, 0.3], [0, 0.3]]))
    x, y = ground.polygon.T
    assert 0.5 * np.sum(x * np.roll(y, -1) - np.roll(x, -1) * y) == pytest.approx(3.0 * 0.2), "counter-clockwise"


def test_a_corner_written_twice_counts_once():
    corners = [[0, 0], [500, 0], [500, 0], [500, 300], [0, 300], [0, 300]]
    stone = wall_from(record(), "stem").blocks[1]
    blocks = [record()["blocks"][0], {"id": 9, "polygon": corners, "unit_weight": 30}]
    assert wall_from(record(blocks=blocks), "stem").blocks[1].polygon == pytest.approx(stone.polygon)


def test_running_bond_staggers_its_courses_on_one_wider_support():
    wall = running_bond(2, 2, block_length=0.4, block_height=0.2)
    check_wall(wall)
    boxes = {(b.id, *np.round([*b.polygon.min(axis=0), *b.polygon.max(axis=0)], 9)) for b in wall.blocks}
    assert boxes == {
        (0, -0.2, -0.2, 1.0, 0.0),
        (1, 0.0, 0.0, 0.4, 0.2),
        (2, 0.4, 0.0, 0.8, 0.2),
        (3, 0.0, 0.2, 0.2, 0.4),
        (4, 0.2, 0.2, 0.6, 0.4),
        (5, 0.6, 0.2, 0.8, 0.4),
    }
    assert [block.fixed for block in wall.blocks] == [True] + [False] * 5


VALUES = st.recursive(
    st.none() | st.booleans() | st.integers() | st.floats() | st.text(max_size=8),
    lambda children: st.lists(children, max_size=4) | st.dictionaries(st.text(max_size=6), children, max_size=3),
    max_leaves=8,
)
BLOCK = st.dictionaries(st.sampled_from(["id", "polygon", "fixed", "unit_weight", "x"]), VALUES, max_size=5)


@settings(max_examples=200, deadline=None)
@given(
    st.fixed_dictionaries(
        {},
        optional={
            "units": VALUES | st.just({"length": "m", "unit_weight": "kN/m3"}),
            "thickness": VALUES,
            "unit_weight": VALUES | st.floats(0.1, 100),
            "friction": VALUES,
            "blocks": VALUES | st.lists(BLOCK | VALUES, max_size=3),
        },
    )
)
def test_no_block_file_gets_further_than_a_case_error(changes):
    said = ""
    try:
        check_wall(wall_from(record(**changes), "stem"))
    except CaseError as error:
        said = str(error)
    assert "\n" not in said


def test_a_file_that_is_a_list_or_too_deep_is_refused(tmp_path):
    for text in ("[]", "[" * 100_000, '{"blocks": 1e999}', "\ufeff{}", '{"friction": 0.6, "friction": 0.1}'):
        (tmp_path / "wall.json").write_text(text)
        with pytest.raises(CaseError, match=r"wall\.json"):
            read_blocks(tmp_path / "wall.json")


def test_unknown_keys_are_refused_and_information_is_not(tmp_path):
    (tmp_path / "wall.json").write_text(json.dumps(record(source="a survey", licence="CC0")))
    assert read_blocks(tmp_path / "wall.json").friction == pytest.approx(0.7)
    (tmp_path / "wall.json").write_text(json.dumps(record(thicknes=3)))
    with pytest.raises(CaseError, match=r"thicknes.*did you mean thickness"):
        read_blocks(tmp_path / "wall.json")


def refusal(blocks):
    with pytest.raises(CaseError) as refused:
        wall_from(record(blocks=blocks), "stem")
    return str(refused.value)


@pytest.mark.parametrize("corner", [["0", "0"], [False, False], [None, 0], [0, 0, 0], [0], "00", {}, [10**400, 0]])
def test_a_coordinate_must_be_a_number(corner):
    ground, stone = record()["blocks"]
    assert "block 9.polygon: " in refusal([ground, stone | {"polygon": [corner] * 4}])


@pytest.mark.parametrize("far", [1e200, -1e307, float("inf"), float("nan")])
def test_a_coordinate_whose_square_overflows_is_refused_without_a_warning(far, recwarn):
    ground, stone = record()["blocks"]
    line = refusal([ground, stone | {"polygon": [[0, 0], [far, 0], [far, far], [0, far]]}])
    assert line == "block 9.polygon: a coordinate is not a finite number; give finite coordinates"
    assert not recwarn.list


@pytest.mark.parametrize("noise", [1e-300, 1e-11])
def test_corners_that_differ_by_rounding_count_once(noise):
    ground, stone = record()["blocks"]
    corners = [[0, 0], [500, 0], [500, noise], [500, 300], [0, 300]]
    read = wall_from(record(blocks=[ground, stone | {"polygon": corners}]), "stem").blocks[1].polygon
    assert read == pytest.approx(np.array([[0, 0], [0.5, 0], [0.5, 0.3], [0, 0.3]]), abs=1e-12)
    pointed = [*corners[:2], [500, 1e-3], *corners[3:]]
    assert len(wall_from(record(blocks=[ground, stone | {"polygon": pointed}]), "stem").blocks[1].polygon) == 5


def test_name_is_the_file_s_own_or_its_stem_and_can_be_written(tmp_path):
    assert wall_from(record(name="north wall"), "stem").name == "north wall"
    (tmp_path / "wall.json").write_text(json.dumps(record(name="\ud800")))
    with pytest.raises(CaseError, match=r"wall\.json: name: '.ud800' is not UTF-8; rename it"):
        read_blocks(tmp_path / "wall.json")


@pytest.mark.parametrize(
    ("change", "complaint"),
    [
        ({"id": 9.0}, r"blocks\[1\]\.id: is missing or not a whole number"),
        ({"id": True}, r"blocks\[1\]\.id: is missing or not a whole number"),
        ({"fixed": 1}, r"block 9\.fixed: 1 is neither true nor false"),
        ({"unit_weight": True}, r"block 9\.unit_weight: True is not a number"),
        ({"unit_weight": "20 kN/m3"}, r"block 9\.unit_weight: '20 kN/m3' is not a number"),
    ],
)
def test_values_of_another_type_are_refused(change, complaint):
    ground, stone = record()["blocks"]
    with pytest.raises(CaseError, match=complaint):
        wall_from(record(blocks=[ground, stone | change]), "stem")


def test_a_third_unit_is_refused():
    with pytest.raises(CaseError, match=r"units\.force: is not a known key; known keys are length, unit_weight"):
        wall_from(record(units={"length": "mm", "unit_weight": "kN/m3", "force": "kN"}), "stem")


@pytest.mark.parametrize("spike", [[1.4, 0.5], [1.4, 0.5 + 1e-16]])
def test_a_spike_without_area_is_no_corner(spike):
    """An outline that goes out along a line and back, as boolean operations leave it."""
    row = {"polygon": [[0.0, 0.0], [1.0, 0.0], [1.0, 0.5], spike, [0.0, 0.5]]}
    assert polygon_of(row, 1).tolist() == [[0.0, 0.0], [1.0, 0.0], [1.0, 0.5], [0.0, 0.5]]


def test_a_tip_with_an_area_stays():
    row = {"polygon": [[0.0, 0.0], [1.0, 0.0], [1.0, 0.5], [1.4, 0.501], [0.0, 0.5]]}
    assert len(polygon_of(row, 1)) == 5


def test_the_wall_needs_no_unit_weight_where_every_block_has_its_own():
    ground, stone = record()["blocks"]
    given = record(blocks=[ground | {"unit_weight": 18}, stone])
    del given["unit_weight"]
    assert [block.unit_weight for block in wall_from(given, "stem").blocks] == [18e3, 30e3]
    given["blocks"] = [ground, stone]
    with pytest.raises(CaseError, match="unit_weight: is missing, and block 7 has none; give the wall one, or every"):
        wall_from(given, "stem")
