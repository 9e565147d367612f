"""What λ multiplies is named, floors only where it multiplies them, wherever a weight or a multiplier is shown."""

from __future__ import annotations

import math
import re
from dataclasses import replace

import pytest

from orchestrator.app.case_check import loads_table
from orchestrator.app.commands import console_of
from orchestrator.limit_analysis import analyse
from orchestrator.loads import DeadLoad, LiveLoad, LoadSettings, loads_on
from orchestrator.present import plots
from orchestrator.present.answer import answer_of_limit
from orchestrator.present.phrases import phrases
from orchestrator.present.tables import limit_table
from orchestrator.present.weights import load_words, weight_words
from orchestrator.settings.inventory import load_sums
from tests.support.limit_analysis_cases import assemblage_of, box

FLOOR, SHELF = DeadLoad((1,), force=6e3, inertia=True), DeadLoad((1,), force=2e3)
ALONE = "weight 10.000 kN"
FLOORED = "weight of the blocks 10.000 kN, with floors 16.000 kN"
BOTH = "weight of the blocks 10.000 kN, with extra dead load 18.000 kN, base shear 16.000 kN at λ = 1"


def block_under(load):
    """A block of 10 kN, 0.5 m wide and 1 m high, and its limit analysis under a load."""
    assemblage = assemblage_of([box(-3, -1, 6, 1), box(0, 0, 0.5, 1.0)])
    return assemblage, analyse(assemblage, loads=loads_on(assemblage.wall, load))


@pytest.mark.parametrize(
    ("load", "weights", "multiplied"),
    [
        (LoadSettings(), ALONE, "λ × weight"),
        (LoadSettings(dead=(FLOOR,)), FLOORED, "λ × weight with floors"),
        (LoadSettings(dead=(SHELF,)), "weight of the blocks 10.000 kN, with extra dead load 12.000 kN, base "
         "shear 10.000 kN at λ = 1", "λ × weight of the blocks"),
        (LoadSettings(dead=(FLOOR, SHELF)), BOTH, "λ × live load"),
        (LoadSettings(dead=(FLOOR,), distribution="mass_height"), FLOORED, "λ × weight with floors × height"),
    ],
)  # fmt: skip
def test_weight_and_what_lambda_multiplies_say_whether_floors_are_in(load, weights, multiplied):
    """Floors are what λ accelerates; a force on a stone that has no mass is an extra dead load."""
    _, analysis = block_under(load)
    assert weight_words(analysis) == weights
    assert load_words(load.distribution, analysis) == multiplied
    for language in ("it", "pt"):
        told = " ".join([phrases(language)(weights), phrases(language)(multiplied)])
        assert not re.search("weight|floor|shear|load|height", told)


def test_pictures_of_a_wall_with_a_floor_name_both_weights():
    load = LoadSettings(dead=(FLOOR,))
    assemblage, analysis = block_under(load)
    loads = load_words("mass", analysis), weight_words(analysis)
    for figure in (
        plots.mechanism(assemblage, analysis.headline, load.vector, *loads),
        plots.given(assemblage, load, ()),
    ):
        axes = figure.axes[0]
        assert FLOORED in " ".join(axes.get_title().split())
        assert "λ × weight with floors" in [text.get_text() for text in axes.texts]


def test_the_axis_of_multipliers_names_the_weight_that_they_multiply():
    labels = {}
    for load in (LoadSettings(), LoadSettings(dead=(FLOOR,)), LoadSettings(dead=(FLOOR, SHELF))):
        figure = plots.curves({}, block_under(load)[1], "")
        labels[figure.axes[0].child_axes[0].get_ylabel()] = figure.axes[0].get_title().replace("\n", " ")
    assert labels == {
        "λ = base shear / weight": f"Pushover along +x: {ALONE}",
        "λ = base shear / weight with floors": f"Pushover along +x: {FLOORED}",
        "λ = base shear / horizontal live load": f"Pushover along +x: {BOTH}",
    }


@pytest.mark.parametrize(
    ("angle", "block", "words", "applied"),
    [
        (-90.0, 2, "live load 1.000 kN downwards at λ = 1", "live load 22.40 kN downwards"),
        (90.0, 3, "live load 1.000 kN upwards at λ = 1", "live load 5.600 kN upwards"),
    ],
)
def test_of_an_upright_load_its_size_and_direction_stand_in_place_of_a_base_shear(angle, block, words, applied):
    """A beam of 9.6 kN on a pier, held by a stone of 8 kN: it tips over the pier's edge when 8 x 0.8 = (9.6 + V) x 0.2,
    and when the stone is lifted by V: (8 - V) x 0.8 = 9.6 x 0.2."""
    assemblage = assemblage_of([box(-3, -1, 6, 1), box(0, 0, 1, 1), box(0, 1, 2.4, 0.2), box(0, 1.2, 0.4, 1.0)])
    live = (LiveLoad((block,), force=1e3),)
    load = LoadSettings(distribution="per_block", inclination=math.radians(angle), live=live)
    analysis = analyse(assemblage, loads=loads_on(assemblage.wall, load))
    assert weight_words(analysis) == f"weight 37.600 kN, {words}"
    assert weight_words(load_sums(assemblage.wall, load)) == weight_words(analysis)
    for language in ("it", "pt"):
        assert not re.search("weight|live|load|wards", phrases(language)(weight_words(analysis)))
    assert f": {applied}, " in answer_of_limit(analysis)
    console = console_of(width=100)
    with console.capture() as capture:
        console.print(limit_table(analysis))
        console.print(loads_table(load_sums(assemblage.wall, load)))
    assert "shear" not in capture.get()
    assert f" {applied.split()[2]} " in capture.get()
    assert f"live load at λ = 1, {applied.split()[-1]}" in capture.get()


def test_a_weight_that_rounding_changes_is_the_same_weight():
    _, analysis = block_under(LoadSettings())
    assert weight_words(replace(analysis, horizontal_load=analysis.weight * (1 + 1e-9))) == ALONE
