"""Which number counts: of limit analysis, of a run, and what is said beside it."""

from __future__ import annotations

from dataclasses import replace

import pytest

from orchestrator.limit_analysis import analyse
from orchestrator.present.answer import answer_of_limit, answer_of_run
from orchestrator.storage.notes import remarks
from orchestrator.storage.summary import AtPeak, LimitSummary, LooseStones
from tests.support.limit_analysis_cases import assemblage_of, box
from tests.support.pushed import PUSHED
from tests.support.verdicts import summary


@pytest.fixture(scope="module")
def slender():
    """A block 0.5 m wide and 1 m high overturns at 0.5, with or without dilation."""
    return analyse(assemblage_of([box(-3, -1, 6, 1), box(0, 0, 0.5, 1.0)]))


def without_any_state(analysis):
    return replace(analysis, sequence=None, path=None, lowest=None)


def at(analysis, *, lowest=None, bound=None):
    """Return the analysis with another lowest state or another associative bound."""
    associative = analysis.associative
    if bound is not None:
        associative = replace(associative, load_multiplier=bound)
    found = None if lowest is None else replace(analysis.headline, load_multiplier=lowest)
    return replace(analysis, associative=associative, lowest=found)


def test_the_multiplier_that_counts_is_named_with_its_base_shear(slender):
    said = answer_of_limit(slender)
    assert said.startswith("λ = 0.50000 counts (collapse state met by loading): base shear ")
    assert slender.horizontal_load == 10e3
    assert "base shear 5.000 kN, " in said
    assert "it reaches the associative upper bound" in said


def test_a_lower_state_and_a_higher_bound_are_said(slender):
    said = answer_of_limit(at(slender, lowest=0.45, bound=0.6))
    assert "from 0.45000 to 0.50000" in said
    assert "the associative 0.60000 is an upper bound" in said
    alone = answer_of_limit(at(slender, bound=0.6))
    assert "from" not in alone
    assert "the associative 0.60000 is an upper bound" in alone


@pytest.mark.parametrize("lowest", [0.45, 0.5])
def test_less_borne_in_large_displacements_is_told(slender, lowest):
    """It is no safe side: of 92 pushovers finite elements bear 1 % less in 13 than stones that give way at edges."""
    moved = replace(at(slender, lowest=lowest, bound=0.6), rigid_peak=0.44)
    said = answer_of_limit(moved)
    assert said.endswith(" Lower is λ = 0.44000, the most that rigid blocks bear in large displacements.")
    assert "Lower is" not in answer_of_limit(replace(moved, rigid_peak=0.499 * lowest / 0.5))
    edges = " Lower is λ = 0.42000, about what is left in large displacements as stones give way at edges."
    assert answer_of_limit(replace(moved, pressed_peak=0.42)).endswith(edges)
    assert answer_of_limit(replace(moved, rigid_peak=None, pressed_peak=0.42)).endswith(edges)
    assert answer_of_limit(replace(moved, pressed_peak=0.439)) == said, "that rigid blocks bear is as good"


def test_what_lies_in_points_without_joints_leaves_no_bound(slender):
    """Not even where the state that counts reaches the associative multiplier."""
    said = answer_of_limit(replace(slender, is_bound=False))
    assert said.endswith("the associative 0.50000 is no upper bound, as stones bear where there is no joint.")


def test_the_bound_alone_counts_as_no_more_than_that(slender):
    said = answer_of_limit(without_any_state(slender))
    assert said.startswith("λ = 0.50000 is no capacity (associative solution)")
    assert "an upper bound only" in said


def test_a_state_that_a_wall_was_not_loaded_up_to_may_not_be_the_lowest(slender):
    """A facade of 1,174 stones bears 0.273 in finite elements, its smoothed state is 0.300."""
    state = replace(slender.headline, flow_rule="smoothed")
    wide = replace(at(slender, bound=0.6), path=state, sequence=None, lowest=None, pressed_peak=0.42)
    large = replace(wide, last_rest=0.25, rigid_peak=None)
    said = answer_of_limit(large)
    assert said.startswith("λ = 0.50000 counts for rigid stones (collapse state of smoothed conditions)")
    assert " Lower is λ = 0.42000, about what is left in large displacements as stones give way at edges." in said
    assert said.endswith("it was found at rest up to λ = (0.25000), and may fail in a lower one.")
    assert answer_of_limit(replace(large, last_rest=None)).endswith(
        " is not loaded as drawn: it may fail in a lower state."
    )
    for known in (replace(large, rigid_peak=0.499), replace(large, last_rest=0.501)):
        assert "may fail in a lower" not in answer_of_limit(known), "it fails, or rests, within 1 % of that state"


@pytest.mark.parametrize("rule", ["unloaded", "sequence"])
def test_of_a_wall_that_was_not_loaded_it_is_said_that_it_may_fail_in_a_lower_state(slender, rule):
    """A tied facade of 70 stones had 0.409, the bound; loaded it has 0.385."""
    found = replace(slender, path=replace(slender.path, flow_rule=rule), sequence=None, lowest=None)
    assert answer_of_limit(found).endswith(" This wall is not loaded: it may fail in a lower state.")
    assert "This wall is not loaded" not in answer_of_limit(replace(found, going_down=(1,)))


def test_a_peak_beside_a_state_that_loading_did_not_lead_to_is_not_put_down_to_geometry(slender):
    """The facade of 531 stones: what it loses below that state need not be lost as it moves."""
    peak = replace(slender.path, flow_rule="large_displacements", converged=False)
    drawn = replace(slender.path, load_multiplier=0.52)
    said = answer_of_limit(replace(slender, path=peak, rigid_peak=0.5, drawn=drawn))
    assert said.startswith("Geometry decides: in large displacements the wall bears λ = (0.50000): ")
    unmet = replace(slender, path=peak, rigid_peak=0.5, drawn=replace(drawn, flow_rule="smoothed"))
    assert answer_of_limit(unmet).startswith("In large displacements the wall bears λ = (0.50000): ")


def test_a_last_rest_is_called_no_collapse_state(slender):
    rest = replace(slender.path, flow_rule="last_rest", converged=False)
    said = answer_of_limit(replace(slender, path=rest))
    assert said.startswith("Loading met no limit state; the wall was at rest up to λ = (0.50000): ")
    assert "counts" not in said
    assert "a collapse state with" not in said


def test_beside_a_last_rest_states_found_otherwise_are_told_apart(slender):
    """Nothing may be called a state of rest that is none, nor may it be said that there is no limit state."""
    rest = replace(slender.path, flow_rule="last_rest", converged=False)
    found = replace(slender, path=rest, lowest=replace(slender.path, load_multiplier=0.52), highest=0.55)
    assert "limit states found without loading have 0.52000 to 0.55000; the associative" in answer_of_limit(found)
    assert "such states" not in answer_of_limit(found)
    pressed = answer_of_limit(replace(found, pressed_peak=0.48))
    assert " Lower is λ = 0.48000, about what is left in large displacements" in pressed


def entry(model, peak, *, valid=True, reached=True):
    changed = {"peak_reached": reached, "peak_base_shear": peak, "peak_multiplier": peak / 1e5}
    return replace(PUSHED, model=model, bodies={"macro": 2, "micro": 4}[model], valid=valid, **changed)


def summary_of(*pushovers, failed=None):
    return replace(summary(), pushover=pushovers, failed=failed)


@pytest.mark.parametrize(
    ("pushover", "words", "absent"),
    [
        (
            [entry("macro", 21e3), entry("micro", 20e3)],
            ["20.00 kN counts (λ = 0.2000", "macroblocks (21.00 kN, +5.0%)", "limit analysis (+25.0%)"],
            [],
        ),
        (
            [entry("macro", 25e3 * (1 - 1e-6)), entry("micro", 25e3)],
            ["macroblocks (25.00 kN, +0.0%)", "limit analysis (+0.0%)"],
            ["-0.0"],
        ),
        (
            [replace(entry("macro", 20e3), bodies=4), entry("micro", 20e3)],
            ["FE of every stone); macroblocks are every stone, too (20.00 kN, +0.0%); limit analysis"],
            ["approximation"],
        ),
        ([replace(entry("macro", 21e3), bodies=4)], ["FE of every stone); limit analysis"], ["macroblocks"]),
        ([entry("macro", 21e3)], ["21.00 kN counts", "FE of macroblocks"], ["approximation"]),
        (
            [entry("macro", 21e3), entry("micro", 20e3, valid=False)],
            [
                "21.00 kN counts (λ = 0.2100, FE of macroblocks), but the curve of every stone, the reference of "
                "macroblocks, is not valid; limit analysis"
            ],
            ["20.00"],
        ),
        ([entry("micro", 20e3), entry("macro", 21e3, valid=False)], ["20.00 kN counts"], ["but"]),
        ([entry("micro", 20e3, reached=False)], ["a lower bound", "; limit analysis takes"], ["%"]),
        ([entry("micro", 20e3, valid=False)], ["No peak counts"], ["20.0"]),
    ],
)
def test_the_peak_that_counts(pushover, words, absent):
    said = answer_of_run(summary_of(*pushover))
    assert all(word in said for word in words), said
    assert not any(word in said for word in absent), said


@pytest.mark.parametrize(
    ("macro", "words"),
    [
        (entry("macro", 25e3), "25.00 kN counts (λ = 0.2500, FE of macroblocks), but {why}; limit analysis"),
        (entry("macro", 30e3), "No finite element number counts: 30.00 kN (λ = 0.3000, FE of macroblocks)"),
        (entry("macro", 30e3), "take limit analysis (λ = 0.25000), but {why}."),
        (replace(entry("macro", 30e3), held=True), "(λ = 0.3000, FE of macroblocks), but {why}; as drawn it moves"),
    ],
)
def test_no_number_of_macroblocks_hides_that_their_reference_has_no_curve(macro, words):
    said = answer_of_run(summary_of(macro, failed={"micro": "it broke off"}))
    assert words.format(why="every stone, the reference of macroblocks, has no curve") in said
    assert "reference" not in answer_of_run(summary_of(entry("micro", 25e3), failed={"macro": "it broke off"}))


def test_where_stones_have_fallen_macroblocks_are_compared_as_limit_analysis_is():
    """By multipliers: base shears are of other loads."""
    micro = replace(entry("micro", 20e3), peak_multiplier=0.21, at_peak=AtPeak(fallen=0.05))
    said = answer_of_run(summary_of(replace(entry("macro", 21e3), peak_multiplier=0.21), micro))
    assert "macroblocks (λ = 0.2100, +0.0%) are its fast approximation" in said


def test_macroblocks_that_supports_hold_are_no_stones_and_have_no_peak():
    held = replace(entry("macro", 30e3), held=True)
    said = answer_of_run(summary_of(held))
    assert said.endswith("(limit analysis); whether every stone is, --model micro says.")
    assert remarks(summary_of(held)) == [
        "macro FE: held by supports once it has moved: this load does not bring the wall down"
    ]
    stones = answer_of_run(summary_of(replace(entry("micro", 30e3), held=True)))
    assert stones.endswith("(limit analysis).")


@pytest.mark.parametrize(("drawn", "words"), [(0.2427, "bears λ = 0.2427 there"), (0.0, "does not stand there")])
def test_what_a_wall_that_leans_on_new_contacts_bears_without_them(drawn, words):
    found = summary_of(replace(entry("micro", 60e3), at_peak=AtPeak(drawn_contacts=drawn)))
    assert f"with contacts that were not drawn, without which it {words}" in answer_of_run(found)
    assert ("does not stand" in " ".join(remarks(found))) == (drawn == 0.0)


IN_LARGE = {"rigid_peak": 0.199, "large_displacements": 0.199}


@pytest.mark.parametrize(
    ("changed", "displacements", "ending"),
    [
        ({}, "large", "limit analysis (+25.0%) takes the stones as rigid and displacements as small."),
        ({}, "small", "limit analysis (+25.0%) takes the stones as rigid."),
        (
            IN_LARGE,
            "large",
            "limit analysis takes the stones as rigid: +25.0% in small displacements, -0.5% in large ones.",
        ),
        (
            {"rigid_peak": 0.25004, "large_displacements": 0.25004},
            "large",
            "limit analysis takes the stones as rigid: +25.0% in small displacements and in large ones.",
        ),
        (IN_LARGE, "small", "limit analysis (+25.0%) takes the stones as rigid."),
        (
            {"pressed_peak": 0.19, **IN_LARGE},
            "large",
            "limit analysis takes the stones as rigid: +25.0% in small displacements, -0.5% in large ones; about -5.0% "
            "where stones give way at edges: λ = 0.19000, to which smaller elements (mesh.size) come "
            "nearer.",
        ),
        (  # 0.2 is more than rigid blocks bear: another state, and no matter of elements
            {"pressed_peak": 0.17, "rigid_peak": 0.18, "large_displacements": 0.18},
            "large",
            "limit analysis takes the stones as rigid: +25.0% in small displacements, -10.0% in large ones; about "
            "-15.0% where stones give way at edges: λ = 0.17000.",
        ),
        (
            {"pressed_peak": 0.1985, "rigid_peak": 0.202, "large_displacements": 0.202},
            "large",
            "limit analysis takes the stones as rigid: +25.0% in small displacements, +1.0% in large ones; about -0.7% "
            "where stones give way at edges.",
        ),
        (
            {"going_down": (3,)},
            "small",
            "limit analysis (+25.0%) takes the stones as rigid; finite elements come to rest under the dead load, "
            "which limit analysis leaves open.",
        ),
        ({"pressed_peak": 0.19, **IN_LARGE}, "small", "limit analysis (+25.0%) takes the stones as rigid."),
        (
            {"local_failures": (LooseStones((4,), 0.02, (0.1, 0.1)),)},
            "small",
            "limit analysis (+25.0%) takes the stones as rigid and some that have not fallen here as come loose.",
        ),
        (
            {"rigid_peak": None, "large_displacements": 0.199},
            "large",
            "limit analysis (+25.0%) takes the stones as rigid and displacements as small.",
        ),
        (
            {"non_associative": 0.199, "converged": False, **IN_LARGE},
            "large",
            "limit analysis in large displacements (-0.5%) takes the stones as rigid.",
        ),
        (
            {"non_associative": 0.199, "converged": False, **IN_LARGE},
            "small",
            "limit analysis in large displacements (-0.5%) takes the stones as rigid, finite elements displacements as "
            "small.",
        ),
        (
            {"converged": False},
            "large",
            "the last load at rest in limit analysis (+25.0%), no collapse state, takes the stones as rigid and "
            "displacements as small.",
        ),
        (
            {"non_associative": None},
            "large",
            "the upper bound of limit analysis (+50.0%) takes the stones as rigid and displacements as small.",
        ),
    ],
)
def test_what_limit_analysis_and_finite_elements_do_not_share_is_said_of_the_case_at_hand(
    changed, displacements, ending
):
    found = summary_of(replace(entry("micro", 20e3), displacements=displacements))
    found = replace(found, limit_analysis=replace(found.limit_analysis, **changed))
    assert answer_of_run(found).endswith(f"; {ending}")


def test_what_has_fallen_in_finite_elements_alone_is_said_to_be_in_place_in_limit_analysis():
    found = summary_of(replace(entry("micro", 20e3), at_peak=AtPeak(fallen=0.043)))
    takes = "takes the stones as rigid, displacements as small and what has fallen here as in place"
    assert answer_of_run(found).endswith(f"; limit analysis (+25.0%) {takes}.")


def test_a_peak_far_off_but_among_states_that_limit_analysis_found_is_told_as_another_state():
    """Rubble of 52 stones, finite elements of 0.2 m: 0.4062; loading meets 0.2708, other states reach 0.4060."""
    limit = LimitSummary(0.40867, 0.27081, (0.27081, 0.40597), 1, True, 1e-12, 13e3, 1.0)
    found = replace(summary_of(entry("micro", 40.62e3)), limit_analysis=limit)
    takes = "limit analysis (-33.3%) takes the stones as rigid and displacements as small"
    states = "friction leaves open which state is met: from λ = 0.27081 to 0.40597 were found"
    assert answer_of_run(found).endswith(f"; {takes}; {states}.")
    alike = replace(summary_of(entry("micro", 27.1e3)), limit_analysis=limit)
    assert "friction leaves open" not in answer_of_run(alike)
    rocking = replace(limit, converged=False, large_displacements=0.27081)
    lower = replace(limit, non_associative_range=(0.2408, 0.28))
    below = "friction leaves open which state is met: from λ = 0.24080 to 0.28000 were found"
    assert answer_of_run(replace(alike, limit_analysis=lower)).endswith(f"; {below}.")
    one = replace(limit, non_associative_range=(0.4055, 0.40551))
    assert "leaves open" not in answer_of_run(replace(found, limit_analysis=one)), "one state leaves nothing open"
    by_both = states.replace("friction leaves", "friction or displacements leave")
    assert answer_of_run(replace(found, limit_analysis=rocking)).endswith(f"; {by_both}.")


def test_bonds_that_soften_explain_why_limit_analysis_bears_more():
    found = summary_of(entry("micro", 20e3))
    said = answer_of_run(replace(found, wall=replace(found.wall, bonded=True)))
    taken = "takes the stones as rigid, displacements as small and bonds as plastic, which soften."
    assert said.endswith(f"; limit analysis (+25.0%) {taken}")


def test_bonds_make_limit_analysis_alone_an_upper_estimate():
    found = summary_of(entry("micro", 20e3, valid=False))
    said = answer_of_run(replace(found, wall=replace(found.wall, bonded=True)))
    assert said.endswith("limit analysis alone stands, which takes bonds as plastic, which soften.")
    assert answer_of_run(found).endswith("limit analysis alone stands.")


def test_ties_that_yield_late_explain_why_limit_analysis_bears_more():
    tied = replace(summary_of(entry("micro", 20e3)), settings={"reinforcement": {"ties": [{"strength": "8 kN"}]}})
    taken = "takes the stones as rigid, displacements as small and ties as rigid and plastic, which stretch."
    assert answer_of_run(tied).endswith(f"; limit analysis (+25.0%) {taken}")
