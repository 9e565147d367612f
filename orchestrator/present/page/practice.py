"""What a practice puts into its report: materials, loads, section forces and reactions as tables."""

from __future__ import annotations

from dataclasses import astuple
from math import isfinite
from typing import Any

from orchestrator.assessment.section_forces import reactions, section_forces
from orchestrator.assessment.seismic.settings import limit_states
from orchestrator.assessment.tie_forces import tie_forces
from orchestrator.settings.inventory import joint_classes, load_sums, materials
from orchestrator.storage.stored_run import StoredRun

SHOWN_REACTIONS = 30
"""rows of reactions on the page; all are in reactions.csv"""


def practice_contents(run: StoredRun) -> dict[str, Any]:
    """Return what the template of the practice's tables needs, of a stored run."""
    state = run.analysis.headline
    ties = tie_forces(run.assemblage.wall, run.case.reinforcement.ties, state.tie_forces)
    sections = section_forces(run.assemblage, state.joint_forces, ties)
    supports = reactions(run.assemblage, state.joint_forces, ties)
    return {
        "materials": materials(run.case, run.assemblage.wall),
        "joints": (classes := joint_classes(run.assemblage)),
        "elastic_joints": any(
            isfinite(least) for one in classes for least, _ in (one.normal_stiffness, one.shear_stiffness)
        ),
        "loads": load_sums(run.assemblage.wall, run.case.load),
        "limit_states": limit_states(run.case.seismic),
        "sections": [astuple(one) for one in sections],
        "reactions": [astuple(one) for one in supports[:SHOWN_REACTIONS]],
        "more_reactions": max(len(supports) - SHOWN_REACTIONS, 0),
        "held_ties": any(tie.held is not None for tie in ties),
        "sums": (sum(one.horizontal for one in supports), sum(one.vertical for one in supports)),
        "multiplier": state.load_multiplier,
        "state": state.name,
        "in_brackets": run.summary.limit_analysis.in_brackets,
    }
