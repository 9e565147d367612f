"""What each retry, threshold and fallback of the path earns: pushovers of path.py with each of them taken away.

    python docs/studies/rescues.py [number of processes, default 2]

writes rescues.csv and rescues.md beside this file. A run is left after LIMIT s of CPU time.
"""

from __future__ import annotations

import sys
from concurrent.futures import ProcessPoolExecutor
from dataclasses import replace
from itertools import repeat
from multiprocessing import get_context
from pathlib import Path
from typing import Any

import numpy as np

FOLDER = Path(__file__).parent
sys.path[:0] = [str(FOLDER)]

import path as study

from orchestrator.basis.errors import ConvergenceError
from orchestrator.limit_analysis import LimitAnalysis
from orchestrator.masonry.joints import Assemblage
from orchestrator.pushover.path import growth, increment_solver, motion, stepping
from orchestrator.pushover.settings import NewtonSettings
from orchestrator.pushover.solve import contact_path, newton

LIMIT = 60.0
RUNS = (22, 73, 30, 69, 65, 46, 92, 3, 52, 68, 38, 55, 37, 94, 12, 82)
"""pushovers of all families of path.py that take seconds; stones come loose in 22 and 37, and 68 is the longest arch"""


def _nothing() -> None:
    pass


def _set(module: Any, **values: Any) -> None:
    for name, value in values.items():
        assert hasattr(module, name), name
        setattr(module, name, value)


def _from_the_expected_state(solver: Any, model: Any, problem: Any, first: Any, *_: Any) -> Any:
    return newton.solve_increment(model, solver.system, problem, first, solver.newton)


def _with_coulomb_alone() -> None:
    solved = increment_solver.IncrementSolver._solved

    def of_coulomb(*arguments: Any, friction_of_before: bool = False, **named: Any) -> Any:
        if friction_of_before:
            raise ConvergenceError("Newton", "left out", 0)
        return solved(*arguments, **named)

    _set(increment_solver.IncrementSolver, _solved=of_coulomb)


def _anew_each_time() -> None:
    anew = stepping.Pushover._anew
    _set(stepping.Pushover, _anew=lambda self, aim, again=False: anew(self, aim))


def _static_with_coulomb_alone() -> None:
    static = increment_solver.IncrementSolver.static
    _set(increment_solver.IncrementSolver, static=lambda solver, state, aim, **_: static(solver, state, aim))


def _growth_where_straight(state: Any, bent: float, smaller: bool) -> float:
    return growth.growth(replace(state, phase="load"), bent, smaller)


WITHOUT = {
    "nothing": _nothing,
    "path from kink to kink": lambda: _set(newton, followed=lambda _model, _system, _kinks, solution: (solution, True)),
    "that path may turn": lambda: _set(contact_path, LONGEST_BACK=0.0),
    "a path that leads back is left": lambda: _set(contact_path, LONGEST_BACK=np.inf, FARTHEST_BACK=-np.inf),
    "a second path, from the state before": lambda: _set(
        increment_solver.IncrementSolver, _converged=_from_the_expected_state
    ),
    "100 tolerances are accepted": lambda: _set(
        study, NewtonSettings=lambda: replace(NewtonSettings(), acceptable=1.0)
    ),
    "a quarter of an increment that fails": lambda: _set(stepping, CUTS=dict.fromkeys(stepping.CUTS, 0)),
    "a quarter of an increment that falls from the peak": lambda: _set(
        stepping.Pushover, _passes_a_peak=lambda *_: False
    ),
    "elastic slip as first increment after a motion": lambda: _set(
        stepping.Pushover, _anew=lambda self, aim, again=False: (self._largest(aim.phase) / 16, 0.0)
    ),
    "an increment that bends and misses its work is made smaller": lambda: _set(stepping, balances=lambda *_: True),
    "no growth after an increment that bends": lambda: _set(growth, BENT=np.inf),
    "growth where increments bend at any size": lambda: _set(stepping, growth=_growth_where_straight),
    "a part that slides inside goes farther": lambda: _set(
        stepping.Pushover, _resolved=lambda self, solved, _length: self._largest(solved.phase)
    ),
    "increments above the largest past the peak": lambda: _set(growth, LONGEST_STRAIGHT=1.0),
    "motion goes on from its last step": lambda: _set(motion, carried_on=lambda _m, here, _c, _s: here),
    "friction of the forces before, where Coulomb's leaves no state": _with_coulomb_alone,
    "friction of the forces before, in static increments": _static_with_coulomb_alone,
    "shorter steps of motion after one with friction of before": lambda: _set(motion, OF_BEFORE=""),
    "an end to these": lambda: _set(motion, LEAST_GIVEN=0.0),
    "longer increments from rest to rest": _anew_each_time,
    "a step of motion is made shorter": lambda: _set(motion, TRIES=1),
    "a step in which a body goes too far is made shorter": lambda: _set(motion, TOO_FAR=np.inf),
    "rest is looked for only near it": lambda: _set(motion, NEAR_REST=np.inf),
    "first iteration of a wall without forces is whole": lambda: _set(newton, _at_every_kink=lambda *_: False),
    "no body may miss a thousandth of its weight": lambda: _set(newton, OF_BODIES=np.inf),
    "geometry is solved on again where bodies have turned": lambda: _set(
        increment_solver.IncrementSolver, _turns_allowed=lambda *_: np.inf
    ),
    "a weak wall is measured by its live load": lambda: _set(increment_solver, WEAK=1e-9),
    "supports are asked whether they hold the wall": lambda: _set(stepping, HELD_FROM=np.inf),
}
"""what is taken away -> how"""


def pushed_without(without: str, analysed: dict[int, tuple[str, Assemblage, LimitAnalysis]]) -> list[dict[str, Any]]:
    """Return the rows of all pushovers without one thing, which stays away in this process."""
    WITHOUT[without]()
    rows = []
    for run, (family, assemblage, analysis) in analysed.items():
        row = {"without": without, "run": run, "family": family}
        rows.append(row | study.pushed_stones(assemblage, analysis, LIMIT))
        print(rows[-1], flush=True)
    return rows


def main(processes: int) -> None:
    """Analyse the walls, run all and write the table."""
    rows: list[dict[str, Any]] = []
    with ProcessPoolExecutor(processes, mp_context=get_context("spawn"), max_tasks_per_child=1) as pool:
        analysed = dict(zip(RUNS, pool.map(study.analysed_run, RUNS), strict=True))
        for of in pool.map(pushed_without, WITHOUT, repeat(analysed)):
            rows.extend(of)
            write(rows)


def write(rows: list[dict[str, Any]]) -> None:
    """Write rescues.csv and rescues.md."""
    study.write_table(FOLDER / "rescues.csv", rows)
    whole = {row["run"]: row for row in rows if row["without"] == "nothing"}
    lines = []
    for without in dict.fromkeys(row["without"] for row in rows):
        of = [row for row in rows if row["without"] == without]
        ended = sum(not str(row["ended"]).startswith(("left", "STOPPED")) for row in of)
        work = [row["iterations"] for row in of]
        off = [100 * abs(row["peak"] / whole[row["run"]]["peak"] - 1) for row in of]
        lines.append(
            f"| {without} | {len(of)} | {ended} | {np.median(work):.0f} | {np.mean(work):.0f} | {max(work)} "
            f"| {np.median(off):.2f} | {max(off):.1f} |"
        )
    head = (FOLDER / "rescues_head.md").read_text()
    names = "| without | pushovers | reach their end | iterations, median | mean | most | peak off, median % | most % |"
    (FOLDER / "rescues.md").write_text("\n".join([head, names, "|" + " --- |" * 8, *lines, ""]))


if __name__ == "__main__":
    main(int(sys.argv[1]) if len(sys.argv) > 1 else 2)
