"""The journal leaves nothing out: its iterations, of increments and of all that was tried, are the systems solved."""

from __future__ import annotations

from mpi4py import MPI

from orchestrator.masonry.patterns import IrregularCourses, Rubble, irregular_courses, rubble
from orchestrator.masonry.wall import Wall
from orchestrator.pushover.path.increment_solver import OF_BEFORE
from orchestrator.pushover.path.stepping import RESTED, Pushover
from orchestrator.pushover.settings import NewtonSettings, SteppingSettings
from orchestrator.pushover.solve.linear_system import LinearSystem
from orchestrator.storage.effort import Effort, effort_of
from tests.support.pushover_chain import model_of


class Counting(LinearSystem):
    """A linear system that counts the matrices it is given."""

    solved = 0

    def solve(self, *given):
        """Solve as a linear system does."""
        self.solved += 1
        return super().solve(*given)


def solved_and_counted(wall: Wall, height: float) -> tuple[int, Effort]:
    """Return the systems solved in the pushover of every stone to a thirtieth of the height, and its effort."""
    model = model_of(wall, large_displacement=True)
    stepping = SteppingSettings(final_displacement=height / 30)
    with Counting(model, MPI.COMM_SELF) as system:
        increments = list(Pushover(model, system, NewtonSettings(), stepping).increments())
        return system.solved, effort_of(increments, model.body_names, model.body_mass)


def test_iterations_are_the_systems_solved():
    """Between them these walls do all that the path does where an increment fails."""
    found = [
        solved_and_counted(rubble(Rubble(1.2, 1.0, stone=0.32, flatness=1.5, seed=seed)), 1.0) for seed in (1, 5, 9)
    ]
    found.append(solved_and_counted(irregular_courses(IrregularCourses(0.8, 0.6, seed=5)), 0.6))
    said = " ".join(action for _, effort in found for action in effort.rescues)
    for solved, effort in found:
        assert effort.newton_iterations == solved
    for action in (OF_BEFORE, RESTED, "a local part moves", "retried", "a shorter step", "what moves is"):
        assert action in said, action
