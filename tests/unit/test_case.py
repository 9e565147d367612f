from __future__ import annotations

import math
from dataclasses import replace
from pathlib import Path

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from orchestrator import case as cases
from orchestrator.errors import CaseError

PROJECT = Path(__file__).parents[2]
BENCHMARK = PROJECT / "templates" / "benchmark1.toml"
WALL = PROJECT / "tests" / "data" / "tower_5_blocks.json"


def test_benchmark_1_is_what_the_paper_ran():
    case = cases.read(BENCHMARK)
    assert case.macroblocks.normal == 1e-3
    assert case.macroblocks.centre_distance == pytest.approx(0.45)
    assert math.isinf(case.macroblocks.tangential)
    assert case.elastic.elastic_modulus == pytest.approx(3.5e9)
    assert case.load.sign == 1
    wall = cases.read_wall(case)
    assert (wall.thickness, wall.friction) == (pytest.approx(0.1), pytest.approx(0.65))
    assert {block.unit_weight for block in wall.blocks} == {25e3}


def test_a_block_file_is_a_case_with_every_default():
    case = cases.read(WALL)
    assert case == cases.Case(cases.WallSettings("tower_5_blocks.json"), name="tower_5_blocks")
    assert case.block_file == WALL


def test_overrides_take_units_lists_and_words():
    case = cases.read(WALL, ["mesh.size=50mm", "run.models=['micro']", "load.direction=-x", "wall.friction=0.4"])
    assert case.mesh.size == pytest.approx(0.05)
    assert case.run.models == ("micro",)
    assert case.load.sign == -1
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
