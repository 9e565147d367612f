"""Remarks that a page shows beside a result or in place of one: each is told in the language of the report."""

from __future__ import annotations

import re

import pytest

from orchestrator.assessment.seismic.in_space import BOUND_ONLY, HEADLINE_ONLY
from orchestrator.assessment.seismic.kinematic_checks import NOT_TURNING
from orchestrator.assessment.seismic.local_mechanism import STANDING_OPEN, UPPER_BOUND, WEDGED
from orchestrator.limit_analysis.gravity import falls
from orchestrator.limit_analysis.remarks import CRUSHING, NO_PATH
from orchestrator.macroblocks.automatic import EVERY_STONE, NO_FEWER, UNPROVEN
from orchestrator.macroblocks.refinement import HELD
from orchestrator.present.page.verdict_page import verdict_contents
from orchestrator.present.phrases import phrases
from orchestrator.present.verdict import STEEP, Answered, verdict
from orchestrator.space.analysis import UNBOUNDED
from tests.support.verdicts import check, of, summary

NEWTON = (
    "Newton: out-of-balance force 2.1e-03 of the weight after 40 iterations, contacts change between body 1 | body 2; "
    "body 3 | body 4; ..."
)
EQUILIBRIUM = "2.10e-03 (at most 0.001) of the peak is missing at the supports"
FALLING = [((2,), 0.5, False), ((2, 3), 1.5, True), (range(1, 12), 2.5, True)]
"""ids of blocks that move, the force that is missing, and whether the wall stands without its extra dead load"""
ON_PAGES = [
    # load cases
    STEEP,
    # limit analysis
    NO_PATH,
    CRUSHING,
    "WARNING: only stones 40, 42 (3.7 % of the dead load) move at the multiplier that counts: what is left may bear "
    "more; analyse the wall without them, too",
    "from 0.2883 on displacements are large",
    "stones that touch in one point bear nothing there in limit analysis, and may in finite elements: 10 | 14 "
    "(1.347, 2.646) m; all multipliers of limit analysis, the associative one too, may be too low",
    "loading: no state of rest under the dead load was found",
    "refined: in finite elements 2 bear 0.2889, 4 bear 0.3001 (not valid), 8 bear 0.2889 (rigid blocks 0.2890)",
    "loading: no state of rest under the dead load was found: stone 65 goes down unless wedged",
    "loading: no state of rest under the dead load was found: stones 65, 66 go down unless wedged",
    "the path was not followed to its end: state closed by smoothed conditions; the wall was not loaded in small "
    "displacements, for the number of blocks",
    "the path was not followed to its end: state closed by two programs from the mechanism at its last rest; at rest "
    "up to 0.4047, no rest found at 0.4497",
    "the path was not followed to its end: state closed by two programs from the mechanism at its last rest; at rest "
    "up to 0.4047",
    "the path was not followed to its end: state closed by the paper's sequence; at rest up to 0.4047",
    "loading: at rest up to 0.4047, but no limit state was closed there: the headline is that rest",
    "loading: at rest up to 0.4047 and not at 0.4497, but no limit state was closed there",
    "given up after so many steps: between that rest and the bound nothing is known",
    "given up after so many steps: between that rest and 0.4497 nothing is known",
    "the paper's sequence left out for so many blocks, more than 500",
    "the paper's sequence found no state: what it settled on would have to be held, at λ = -0.008165",
    "the paper's sequence found no state: sequence of Eq. (2): linear program not solved in 12 iterations",
    "geometry decides: rigid blocks in large displacements bear 0.2776, in small ones 0.3200",
    "rigid blocks in large displacements bear at least 0.0271, in small ones 0.0272",
    "rigid blocks in large displacements bear 0.0271, in small ones 0.0272",
    "at rest up to 0.1911; once it moves it carries 0.0376",
    "at rest up to 0.0271; as it moves what it bears falls to 0.0000 or less",
    "limit analysis takes bonds as plastic, with their strength in all of a joint at once: finite elements, in which "
    "they break, may bear less (`run`)",
    "rigid blocks in large displacements bear 0.2984; a state in small ones, closed by smoothed conditions without "
    "loading, has 0.3079",
    "rigid blocks in large displacements bear at least 0.3200; a state in small ones, closed by smoothed conditions "
    "without loading, has 0.3079",
    "in large displacements rigid blocks bear at most 0.3100",
    "in large displacements rigid blocks bear at least 0.3100",
    "the peak in large displacements depends on the elastic modulus of the stones, here 3.5 GPa",
    "the peak in large displacements depends on the elastic modulus of the stones, here 3.5 to 11 GPa",
    "rigid blocks on springs lose 14 % as they move; stones that give way at edges and bend may lose more: finite "
    "elements tell (`run`)",
    "in large displacements no rest under a live load was found, with an elastic modulus of 0.35 GPa",
    "in the mechanism blocks 10 and 14 go into each other at (1.348, 2.646) m: no joint keeps them apart there, and "
    "the multiplier may be too low",
    "in the mechanism blocks 50 and 63 go into each other at (1.943, 1.919) m (one of 2 such pairs): no joint keeps "
    "them apart there, and the multiplier may be too low",
    # macroblocks
    EVERY_STONE,
    NO_FEWER,
    UNPROVEN,
    HELD,
    "all blocks are one macroblock: it can only slide or overturn on its support",
    "3 joints inside macroblocks exceed a tolerance; their blocks are joined through others",
    "tie 1 joins two stones of one macroblock: it holds nothing that could part there",
    # reactions and section forces
    "all supports and anchors",
    "tie 1",
    "tie 12 with piers",
    "tie 12 with spandrel above",
    "tie 12 with spandrel below",
    # curves
    f"micro FE: stopped after increment 7 (displacement, 1.234 mm, multiplier 0.2500): {NEWTON}",
    f"macro FE: stopped before any increment: {NEWTON}",
    "macro FE: body 3 fell after 12.34 mm, with no contact left",
    "micro FE: stopped after increment 7 (load, 1.234 mm, multiplier 0.2500): Newton: no motion is found: geometry: "
    "bodies turn by 2.0e-03 more than expected",
    "gravity: the wall has not come to rest under its dead load in 3 increments (stepping.largest_increments)",
    "gravity: the wall does not stand under its dead load: block 3 falls",
    "micro FE: stopped after increment 9 (gravity, 0.1 mm, multiplier 0.0000): gravity: the wall does not stand under "
    "its dead load: block 1 falls; its ties are tightened meanwhile (reinforcement.ties.pretension)",
    "linear solver: refinement ends at 1e-02 of 4e+00",
    f"micro FE: equilibrium: {EQUILIBRIUM}",
    f"micro FE: equilibrium: {EQUILIBRIUM}, and penetration: 2.10e-01 (at most 0.05) of the smaller body's size is the "
    "depth to which block 49 and the support overlap at (1.967, 1.933) m, from 20.5 mm on",
    "macro FE: touch: 2.10e-01 (at most 0.05) of the smaller body's size is the gap across which block 49 and the "
    "macroblock of block 62 press each other at (1.967, 1.933) m, from 20.5 mm on",
    "the curve ends before 8.405 mm: from there on the macroblock of block 50 and block 63 overlap at (1.952, 1.926) "
    "m, 5.12e-03 of the smaller one's size (at most 0.005)",
    "the curve ends before 8.405 mm: from there on block 50 and the support press each other across a gap at (1.952, "
    "1.926) m, 5.12e-03 of the smaller one's size (at most 0.005)",
    "macro FE: energy balance: 2.10e-01 (at most 0.05) of stored energy, friction and the live load's work is missing",
    "macro FE: static theorem: 2.10e-01 (at most 0.05) is what the peak is above the associative multiplier",
    "micro FE: end of the curve: it broke off: stopped after increment 7 (load, 1.234 mm, multiplier 0.2500): "
    + NEWTON,
    "micro FE: held by supports once it has moved: this load does not bring the wall down",
    "micro FE: held by supports at a load multiplier of 1.22: this load does not bring the wall down",
    "micro FE: the peak 0.0524 is more than 10 % below 0.1730, the least that every stone bears in limit analysis as "
    "loading meets it: friction may lead to another state, or elements are too long: compare with a quarter of "
    "mesh.size",
    "micro FE: the peak 0.1778 is more than 10 % below 0.2241, the least that every stone bears in limit analysis as "
    "loading meets it: friction may lead to another state, as were found from 0.1683 on, or elements are too long: "
    "compare with a quarter of mesh.size",
    "micro FE: the peak 1.4331 is more than 5 % above 1.3280, what every stone bears in limit analysis: friction may "
    "lead to another state, or elements are too long: compare with a quarter of mesh.size",
    "micro FE: the peak 0.2756 is more than 5 % above 0.1461, what every stone bears in limit analysis, with what has "
    "fallen here in its place: friction may lead to another state, or elements are too long: compare with a quarter of "
    "mesh.size",
    "macro FE: the peak is of what is left when 37 % of the dead load has fallen",
    "micro FE: block 28 (0.87 % of the dead load) fell at a load multiplier of 0.4784; the wall went on",
    "micro FE: block 8 (0.87 % of the dead load) fell after the peak, at a load multiplier of 0.2597; the wall went on",
    "micro FE: block 28 (0.87 % of the dead load) fell under the dead load alone; the wall went on: in finite elements "
    "joints slip by up to contact.slip_tolerance before friction holds; limit analysis has all stones standing there: "
    "try a smaller contact.slip_tolerance",
    "micro FE: block 40, block 31 and 2 more (5.2 % of the dead load) fell under the dead load alone; the wall went "
    "on: in limit analysis, too, stones come loose under next to no live load, or none",
    "micro FE: block 40, block 31 and 2 more (5.2 % of the dead load) fell under the dead load alone; the wall went "
    "on: in limit analysis, too, stones go down there unless they are wedged",
    "every stone, the reference of macroblocks, has no curve",
    "the curve of every stone, the reference of macroblocks, is not valid",
    "micro FE: the peak 0.5765 is more than 5 % above 0.2500, the most that the joints drawn can bear, as a gap has "
    "closed or a stone has moved onto another: without contacts that were not drawn the wall, as it has moved, bears "
    "at most 0.2427",
    "micro FE: the peak 0.5765 is more than 5 % above 0.2500, the most that the joints drawn can bear, as a gap has "
    "closed or a stone has moved onto another: without contacts that were not drawn the wall, as it has moved, does "
    "not stand",
    "micro FE: distrust the peak 0.7000: it is more than 5 % above 0.6471, the most that rigid stones can bear in "
    "small displacements, or as far as they were pushed; look at the deformed wall, and compare with a finer mesh.size",
    "macro FE: the peak 0.1875 is more than 5 % above that of every stone in limit analysis (0.1348), and does not "
    "count: compare with --model micro",
    # seismic verification
    f"the curve is not valid: equilibrium: {EQUILIBRIUM}",
    UPPER_BOUND,
    NOT_TURNING,
    "analysed for a horizontal load proportional to mass, not for the load of this case",
    "under a horizontal load proportional to mass: the load multiplier has no upper bound",
    "a local failure: stones 3, 4 (12 % of the dead load) move, not the wall",
    "a local failure: stone 3 (12 % of the dead load) moves, not the wall",
    WEDGED,
    STANDING_OPEN,
    "micro FE: it is not at rest under any live load: base shear 20 % below its peak",
    "whether the wall stands is open: stone 58 goes down under the dead load unless wedged",
    "whether the wall stands is open: stones 58, 59 go down under the dead load unless wedged",
    "local failure under the dead load: stone 3 (0.12 % of the dead load) comes loose, unless wedged",
    "local failure under the dead load: stones 3, 4 (1.2 % of the dead load) come loose, unless wedged",
    "local failure at 0.2500: stones 3, 4 (12 % of the dead load) come loose",
    "local failure at 0.2500 to 0.3000: stone 3 (12 % of the dead load) comes loose",
    "alpha_0 is the last load at which the wall rests: no limit state was closed",
    "alpha_0 is the peak in large displacements: it lies below the collapse state of the wall as drawn",
    "the spectrum is that on the ground, not at mechanism_height",
    "the curve ends at 12.3 mm, short of 150% of the target displacement, 20 mm (EN 1998-1 4.3.3.4.2.3)",
    "top of block 3 does not move along the load: name another control point",
    "a bond that has opened bears nothing: alpha_0 = 0.5 then, 0.75 to open it",
    f"once its bond has opened: {UPPER_BOUND}",
    *(f"once its bond has opened: {falls(*told, 'move').problem}" for told in FALLING),
    "friction or crushing of joints takes 54% of the live load's power: d0* is an upper bound, and what passes by it "
    "is not verified",
    "friction or crushing of joints takes 33% of the live load's power, and is taken to do so to the end: d0* is an "
    "upper bound",
    "WARNING: 10.5 kN of dead load have weight, but no mass in the seismic verification; if they move with the wall, "
    "give inertia = true to load.dead.0, load.dead.2",
    "top of block 4 has fallen: name stones that stand in seismic.control_blocks",
    "the curve ends before its peak: a lower bound",
    "the curve does not rise from the state under gravity",
    "the curve ends before the areas can be made equal",
    "the control displacement does not go along the live load",
    "none: the control displacement does not go along the live load",
    "micro FE: beyond λ = 0.1450 the wall found no rest before its top had moved by 4.98 mm, 99 % of what it has moved "
    "at its peak: motion has no inertia here, and an earthquake may carry it on",
    "micro FE: beyond λ = 0.3000 the wall found no rest before a part of it had gone 30 mm, which its top does not show"
    ": motion has no inertia here, and an earthquake may carry it on",
    "micro FE: by the load after λ = 0.2222 its top had moved by 13.5 mm, 27 % of what it has moved at its peak, "
    "bearing more and more: whether it rests on the way a smaller stepping.load_increment tells",
    "micro FE: by the load after λ = 0.2222 a part of it had gone 13.5 mm, which its top does not show, bearing "
    "more and more: whether it rests on the way a smaller stepping.load_increment tells",
    "micro FE: the peak is a spike: when its top has moved by 0.054 mm more the wall bears λ = 0.1417; such a peak may "
    "depend on the elements: compare with a quarter of mesh.size",
    "micro FE: the mean of the top edge moves 0.12 % of the stone that goes farthest: it is outside the mechanism; "
    "displacements and stiffness of this curve are not of what fails",
    "micro FE: at first the mean of the top edge moves against the live load: base shear over that displacement is no "
    "stiffness of the wall, and none is given",
    "the control displacement is zero in the first lateral increments",
    "stones give way at the edges that they turn about: about 0.2851 is left in large displacements, finite elements "
    "tell (`run`)",
    "WARNING: stones give way at the edges that they turn about: about 0.0211 is left in large displacements, finite "
    "elements tell (`run`)",
    "WARNING: stones give way at the edges that they turn about: about nothing is left in large displacements; "
    "finite elements tell whether the wall stands (`run`)",
    "WARNING: what leans on the joint of blocks 0 and 1 loses about 23 % of what it bears as drawn, as stones give way "
    "at the edge and bend: rigid blocks know little of it, finite elements do (`run`)",
    "bonds: 27 % of the peak may be too much, as elements are too long where they crack: refine mesh.size, 17 mm are "
    "enough",
    "micro FE: the peak may be 4.1 % too high, as elements are too long where bonds crack: refine mesh.size, 17 mm are "
    "enough",
    "loading was not found to come to the paper's value 0.0660, a state of other forces between the stones",
    "the paper's value is none of the wall: only 0.079 % of the dead load moves at it (stones 13)",
    # outlines
    "WARNING: the outline of block 22 goes out to (1.5, 0.9) m and back on itself, 200 mm far: that spike is taken "
    "away; was a corner forgotten?",
    # joints
    "WARNING: 8 pairs of blocks lie 1 to 2.5 mm apart or over each other, without a joint there, the first between "
    "blocks 2 and 18 at (0.8005, 0.125) m; joints.tolerance is 0.0087 mm: if these are errors of the drawing, import "
    "the file with a larger --tolerance, or --mortar",
    "WARNING: 8 pairs of blocks lie 1 mm apart or over each other, without a joint there, the first between blocks 2 "
    "and 18 at (0.8005, 0.125) m; joints.tolerance is 0.0087 mm: if these are errors of the drawing, import the file "
    "with a larger --tolerance, or --mortar",
    "WARNING: 1 pair of blocks lies 1 mm apart or over each other, without a joint there, the first between blocks 2 "
    "and 18 at (0.8005, 0.125) m; joints.tolerance is 0.0087 mm: if these are errors of the drawing, import the file "
    "with a larger --tolerance, or --mortar",
    # joint classes
    "WARNING: joints.classes.3 acts on no joint: it gives no value",
    "WARNING: joints.classes.0 acts on no joint: the wall has no head joint between a and b; not used: friction",
    "WARNING: joints.classes.0 acts on no joint: the wall has no bed joint; not used: friction, cohesion",
    "WARNING: joints.classes.0.tensile_strength: 0.05 MPa is more than cohesion over friction, where joints open at "
    "the latest: it counts as 0.017 MPa there",
    "WARNING: joints.classes.1: later classes replace it in all its joints; not used: friction",
    # walls in space
    "WARNING: 7 common areas too small for a joint (contact.smallest), between blocks 1 | 2 (0.3 mm2), 2 | 5 (1 mm2)",
    "WARNING: 1 common area too small for a joint (contact.smallest), between blocks 1 | 2 (0.3 mm2)",
    "WARNING: no joint where blocks lie a little more than contact.gap apart: 1 | 2, 2 | 5",
    "corners lie up to 0.058 mm off planes that they have in common, and were put there (contact.gap)",
    "WARNING: corners lie up to 0.61 mm off planes that they seem to have in common, and contact.gap = 0.001 leaves "
    "them there: 0.004 puts them in",
    "WARNING: the push on elastic joints found no state (not at rest after 1200 factorisations: λ 0.1234, "
    "flow error 3e-01); that "
    "with equal springs did",
    "WARNING: loading had not come to rest at λ = (0.1500), and the wall may fail there: give limit_analysis.time more",
    "WARNING: the push on elastic joints found no state (flow 2.1e-05 > 1e-06); the headline is the state that its "
    "end was closed to",
    "WARNING: no state without dilation found: the push on elastic joints found no state (not at rest "
    "after 100 factorisations: "
    "λ 0.0303, flow error 1e+01); nearest to one: λ 0.0303, 1e+01 of its power out of balance; the associative "
    "multiplier is a bound",
    f"WARNING: {UNBOUNDED}",
    "states at λ = -0.1000, 0 need no live load: what moves in them stands only as its joints are pressed beforehand; "
    "they are no capacities",
    "λ = (0.11068) counts (descent from elastic joints, turn 10, a state but for 2e-05 of its power): base shear "
    "4.383 kN, a collapse state with friction that does not dilate; the associative 0.14202 is an upper bound.",
    "WARNING: the push on elastic joints found no state (not at rest after 1000 factorisations: λ 0.1095, "
    "flow error 2e-02); the "
    "headline is what is nearest to one",
    "WARNING: the push on elastic joints found no state (not at rest after 1000 factorisations: λ 0.1095, "
    "flow error 2e-02); its "
    "end is nearly one",
    "λ = 0.13333 counts (elastic joints): base shear 6.400 kN, a collapse state with friction that does not dilate; "
    "there is no upper bound, as joints whose sliding dilates would bear any load.",
    "λ = 0.30000 counts (elastic joints): base shear 3.000 kN, a collapse state with friction that does not dilate; "
    "such states were found from 0.30000 to 0.32250, as friction leaves the answer open; "
    "there is no upper bound, as joints whose sliding dilates would bear any load.",
    "e* = 0.912; a0* = λ g / e* = 1.736 m/s2 (0.177 g), of the lowest state found, λ = 0.1614",
    "e* = 0.640 is below 0.75, and counts as 1; a0* = λ g / e* = 1.736 m/s2 (0.177 g), of the lowest state found, "
    "λ = 0.1770",
    "λ = 0.36842 counts (elastic joints): base shear 0.2358 kN, a collapse state with friction that does not dilate; "
    "such states were found from 0.30612 to 0.44828, as friction leaves the answer "
    "open; the associative 0.48359 is an upper bound.",
    "λ = 0.36842 counts (descent from elastic joints, equal springs, turn 2): live load 0.2358 kN upwards, a "
    "collapse state with friction that does not dilate; the associative 0.48359 is an upper bound.",
    "Whether it stands is open; if it does, λ = 0.20000 counts (highest from dilation shift): live load 3.200 kN "
    "downwards, a collapse state with friction that does not dilate; it reaches the associative upper bound, and no "
    "lower one was found.",
    "λ = 0.20000 counts (descent from smoothed contact, turn 1): base shear 3.200 kN, a collapse state with friction "
    "that does not dilate; it reaches the associative upper bound, and no lower one was looked for.",
    "λ = 0.20000 is no capacity (associative): base shear 3.200 kN, an upper bound only, as no state with friction "
    "that does not dilate was found.",
    "Whether it stands is open; λ = 0.20000 is no capacity (associative): base shear 3.200 kN, an upper bound only, as "
    "no state with friction that does not dilate was looked for.",
    "λ = 0.20000 is no capacity (associative): base shear 3.200 kN, an upper bound only, as no state with friction "
    "that does not dilate was looked for.",
    "Joints that twist as under uniform pressure reach no more than λ = 0.1000, which is lower: how they twist "
    "decides.",
    "Joints that bear at their corners only reach no more than λ = 0.1000, which is lower: how they twist decides.",
    "2 kN each on blocks 1, 2, 3, 4, ..., along (0, 1, 0); in all 2.000 kN, with mass",
    f"not made: {BOUND_ONLY}",
    f"not made: {HEADLINE_ONLY}",
    f"not made: {UPPER_BOUND}",
]
LEFT = re.compile(r"\b(WARNING|the|of|is|are|at|by|and|not|wall|that|which|after|with|bear)\b")


@pytest.mark.parametrize("remark", ON_PAGES)
def test_a_remark_is_told_without_a_word_of_english(remark):
    for language in ("it", "pt"):
        told = phrases(language)(remark)
        assert not LEFT.search(told), told
        assert sorted(re.findall(r"\d+", told)) == sorted(re.findall(r"\d+", remark))


def test_a_sentence_with_a_list_in_it_is_told_as_a_whole():
    said = "refined: in finite elements 2 bear 0.3903, 4 bear 0.2781 (rigid blocks 0.2803)"
    assert phrases("it")(said) == (
        "raffinati: agli elementi finiti 2 portano 0,3903, 4 portano 0,2781 (blocchi rigidi 0,2803)"
    )
    assert phrases("pt")("2 bear 0.3903, 4 bear 0.2781") == "2 suportam 0,3903, 4 suportam 0,2781"


def test_each_of_several_remarks_of_a_row_is_told():
    refused = {"approach": "N2, micro-FE", "limit_state": "all", "refused": UPPER_BOUND, "remarks": []}
    pier = "no pier reaches its limit, here 0.75%: the end of the curve stands for it, a lower bound"
    two = check(1.5) | {"remarks": ["q* = 3.5 is above 3", pier]}
    found = of(a=summary(refused, two, valid=False))
    shown = [row["remarks"] for row in verdict_contents(found, "it")["rows"]]
    assert shown[0] == "nessuna curva è valida"
    assert shown[1] == phrases("it")(UPPER_BOUND)
    assert shown[2].startswith("q* = 3,5 è maggiore di 3; nessun maschio")
    answered = Answered(
        "a", "+x", "mass", None, (ON_PAGES[-1], "gravity: the wall does not stand under its dead load: block 3 falls")
    )
    (row,) = verdict_contents(verdict("wall", [answered]), "it")["rows"]
    assert row["verified"] == "not made"
    assert row["remarks"] == "; ".join(map(phrases("it"), answered.complaints))
    assert not LEFT.search(row["remarks"])
