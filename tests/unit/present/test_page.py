"""The page's data: damage of joints whose gaps are given, packed displacements, rows that stay, numbers as shown."""

from __future__ import annotations

import base64
from types import SimpleNamespace

import numpy as np
import pytest

from orchestrator.basis.errors import CaseError
from orchestrator.present.page.collapse import chosen_rows, ninths, packed
from orchestrator.present.page.damage import damage_sequence
from orchestrator.present.page.writing import fixed, shown
from orchestrator.storage import ContactPlaces
from orchestrator.storage.stored_run import read_run

LIMIT = 1e-5


def states(gaps, slips, damage=None):
    """Increments 5, 6, ...: the state under gravity first; gaps, slips (s, c) in m, damage (s, c) 0 to 1."""
    damage = np.zeros(np.shape(gaps)) if damage is None else damage
    return [
        SimpleNamespace(
            number=5 + n, load_multiplier=0.1 * n, base_shear=100.0 * n, control_displacement=1e-4 + 1e-3 * n,
            gap=np.array(gap), slip=np.array(slip), damage=np.array(degree),
        )
        for n, (gap, slip, degree) in enumerate(zip(gaps, slips, damage, strict=True))
    ]  # fmt: skip


def places(interface):
    return ContactPlaces(np.zeros(len(interface), dtype=np.int64), np.array(interface))


def test_damage_comes_in_order_of_load_with_load_displacement_and_end_value():
    gaps = [[0, 0, 0], [0, 0, 0], [0, 2e-5, 0], [0, 5e-5, 3e-5]]
    slips = [[0, 0, 0], [2e-5, 0, 0], [2e-5, 0, 0], [9e-5, 0, 0]]
    first, second, third = damage_sequence(states(gaps, slips), places([0, 1, 2]), LIMIT)
    assert (first.interface, first.kind, first.step) == (0, "slides", 6)
    assert first.load_multiplier == pytest.approx(0.1)
    assert first.base_shear == pytest.approx(100.0)
    assert first.control_displacement == pytest.approx(1e-3)
    assert first.at_end == pytest.approx(9e-5)
    assert (second.interface, second.kind, second.step) == (1, "opens", 7)
    assert (third.interface, third.kind, third.step) == (2, "opens", 8)


def test_what_gravity_has_opened_is_no_damage_and_a_joint_counts_once():
    gaps = [[1e-3, 0, 0], [1e-3, 2e-5, 4e-5], [1e-3, 9e-5, 9e-5]]
    found = damage_sequence(states(gaps, np.zeros((3, 3))), places([0, 1, 1]), LIMIT)
    assert [(damage.interface, damage.step) for damage in found] == [(1, 6)]


def test_of_joints_that_open_in_one_increment_the_widest_comes_first():
    found = damage_sequence(states([[0, 0], [2e-5, 3e-5]], np.zeros((2, 2))), places([0, 1]), LIMIT)
    assert [damage.interface for damage in found] == [1, 0]


def test_a_contact_that_has_gone_says_nothing():
    assert damage_sequence(states([[0.0], [np.nan]], np.zeros((2, 1))), places([0]), LIMIT) == []


def test_a_joint_whose_faces_are_too_far_apart_for_contacts_is_open_by_more_than_was_seen():
    gaps = [[0.0, 0.0], [3e-5, 2e-5], [np.nan, 8e-5], [np.nan, np.nan]]
    (found,) = damage_sequence(states(gaps, np.zeros((4, 2))), places([0, 0]), LIMIT)
    assert (found.kind, found.at_end, found.at_least) == ("opens", 8e-5, True)
    (found,) = damage_sequence(states(gaps[:2], np.zeros((2, 2))), places([0, 0]), LIMIT)
    assert (found.at_end, found.at_least) == (3e-5, False)


def test_a_bonded_joint_cracks_and_breaks_with_its_last_contact():
    """Joint 0 has two contacts, joint 1 is damaged by half: degrees at the end are the means, 1 and 0.5."""
    damage = [[0, 0, 0], [0.4, 0, 0], [1, 0.2, 0.5], [1, 1, 0.5]]
    found = damage_sequence(states(np.zeros((4, 3)), np.zeros((4, 3)), damage), places([0, 0, 1]), LIMIT)
    assert [(d.interface, d.kind, d.step, d.at_end) for d in found] == [
        (0, "cracks", 6, 1.0), (1, "cracks", 7, 0.5), (0, "breaks", 8, 1.0),
    ]  # fmt: skip


def test_degrees_of_damage_are_one_digit_each():
    assert ninths(np.array([0.009, 0.02, 0.5, 0.999, 1.0])) == "01489"
    assert ninths(np.zeros(4)) == ""


def test_packed_displacements_are_read_back_to_one_part_in_30000_of_the_largest():
    values = np.array([[1.5e-3, -3e-3], [0.0, 1e-6]])
    unit, text = packed(values)
    read = unit * np.frombuffer(base64.b64decode(text), dtype="<i2").reshape(-1, 2)
    np.testing.assert_allclose(read, values, atol=3e-3 / 30000)


def test_rows_thinned_out_keep_both_ends_and_the_peak():
    rows = chosen_rows(1000, 333, 10)
    assert len(rows) <= 11
    assert {0, 333, 999} <= set(rows.tolist())
    assert chosen_rows(7, 3, 100).tolist() == list(range(7))


@pytest.mark.parametrize(
    ("value", "factor", "text"),
    [
        (3359.7, 1e-3, "3.360"),
        (0.5, 1.0, "0.5000"),
        (252, 1.0, "252"),
        (None, 1.0, "–"),
        (1.2346e-7, 1.0, "1.235e-07"),
        (12345.6, 1.0, "12350"),
        (1.2346e7, 1.0, "1.235e+07"),
    ],
)
def test_numbers_as_shown(value, factor, text):
    assert shown(value, 4, factor) == text


def test_what_rounding_leaves_below_zero_is_zero():
    assert [fixed(value) for value in (-1e-17, -4e-4, -6e-4, 0.0)] == ["0.000", "0.000", "-0.001", "0.000"]


def test_a_folder_without_a_finished_run_is_named(tmp_path):
    with pytest.raises(CaseError, match="holds no finished run"):
        read_run(str(tmp_path))
