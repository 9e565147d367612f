"""Up to where a curve in large displacements may be used: as long as displaced outlines show no missing contact.

Its static rows and its last one are looked at, one by one. Where bodies overlap, or press each other from afar, the
curve ends with the row before, as if it had been followed only so far. If its base shear has not fallen by then the
wall bears at least as much: what bodies go through might have held them. A curve past its peak ends where work and
energies balance for the last time, too: an increment may have jumped to another path of equilibrium.

A curve whose peak does not suffice, as that of macroblocks that finer ones follow, ends soon after it. One that bears
more only after a part of the wall has moved as far as the top may, which stands, ends before that.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Sequence
from functools import partial
from itertools import takewhile
from typing import TYPE_CHECKING, Any

import numpy as np

from orchestrator.app.what_moves import STANDS, part_gone
from orchestrator.assessment.capacity import FALLEN, FLAT_LENGTH_RATIO, has_fallen
from orchestrator.basis.errors import ConvergenceError
from orchestrator.macroblocks.bodies import Bodies
from orchestrator.pushover.increments import Increment, PushoverCurve
from orchestrator.pushover.path.body_overlap import DisplacedOutlines
from orchestrator.pushover.path.curve_checks import APART, ENERGY, MISSING, OVERLAP, RowMisfits, said_of
from orchestrator.pushover.settings import SteppingSettings
from orchestrator.storage.effort import with_energy_errors

if TYPE_CHECKING:
    from orchestrator.pushover.model import ContactModel

NOT_ENOUGH = "the peak is behind, and does not suffice: finer macroblocks are to tell another"
"""what a curve says that ended there"""

MORE = 0.01
"""part by which a wall has to bear more once what moves has gone far for its curve to end before that"""

Suffices = Callable[[float], bool]
"""whether a pushover with such a peak, as a multiplier of the live load, is of use beyond it"""


def is_past(increment: Increment) -> bool:
    """Return whether the base shear has fallen from its highest as far as tells a peak."""
    falls = increment.base_shear <= (1.0 - FALLEN) * increment.largest_base_shear
    return falls and increment.phase != "gravity" and not increment.moving


def after_gravity(model: str, last: Increment | None, complaint: Exception | None) -> Increment:
    """Return the last increment. Raises ConvergenceError where it is not past gravity: there is no curve."""
    if last is None or last.phase == "gravity":
        raise complaint if isinstance(complaint, ConvergenceError) else ConvergenceError(f"{model} FE", str(complaint))
    return last


def before_it_goes_far(
    model: ContactModel, increments: Callable[[], Iterable[Increment]], stepping: SteppingSettings
) -> tuple[Callable[[], Iterable[Increment]], str, bool]:
    """Return what yields the increments before a part of the wall has moved by the final displacement along the live
    load since gravity, and the top by no more than STANDS of it; why the curve ends there; and whether it was level.
    All of them, "" and False where that is not so, where the part is local, or where the wall bears no more later.

    The final displacement is that of the top. What slides on while the top stands may meet what is far from it.
    """
    end, rest, last, most, began, far = stepping.end_of(model.height), None, 0, 0.0, 0.0, 0.0
    for one in increments():
        if one.phase == "gravity":
            rest, last = one, one.number
        elif not one.moving and rest is not None:
            moved = 0.0 if far else part_gone(model, stepping, rest, one)
            far = far or moved * (moved >= max(end, abs(one.pushed) / STANDS))
            if far and one.base_shear > (1.0 + MORE) * most > 0.0:
                said = f"what moves has gone {1e3 * end:.4g} mm, the final displacement, and the top has not: "
                level = far >= FLAT_LENGTH_RATIO * began
                return partial(_up_to, increments, last), f"{said}later the wall bears more", level
            if not far:
                began = moved if one.base_shear > (1.0 + FALLEN) * most else began
                last, most = one.number, max(most, one.base_shear)
    return increments, "", False


def _up_to(increments: Callable[[], Iterable[Increment]], last: int) -> Iterator[Increment]:
    """Yield the increments up to the number of the last."""
    yield from takewhile(lambda one: one.number <= last, increments())


def misfits_of(
    bodies: Bodies, model: ContactModel, curve: PushoverCurve, increments: Iterable[Increment]
) -> list[RowMisfits]:
    """Return the misfits of the rows of a curve that are looked at, in order."""
    from orchestrator.pushover.contact.mortar import largest_closing

    outlines, found = DisplacedOutlines(bodies, model.meshes), list[RowMisfits]()
    looked_at = {*curve.static.step.tolist(), int(curve.step[-1])}
    for one in increments:
        if one.number in looked_at:
            moved = one.control_displacement - float(curve.control_displacement_m[0])
            here = (one.displacement, one.fallen)
            overlap = outlines.largest_overlap(*here, largest_closing(model.mortar, one))
            gap = outlines.largest_pressed_gap(*here, model.pairs, one.normal_force, model.body_weight)
            found.append(RowMisfits(one.number, moved, overlap, gap))
    return found


def first_misfit(rows: Sequence[RowMisfits]) -> RowMisfits | None:
    """Return the first row that does not fit, None where all do."""
    return next((row for row in rows if not row.fits), None)


def bears_load(model: str, curve: PushoverCurve) -> PushoverCurve:
    """Return the curve as it is. Raises ConvergenceError where none of its rows is at rest under a live load."""
    if not (curve.static.load_multiplier > 0.0).any():
        raise ConvergenceError(f"{model} FE", f"it is not at rest under any live load: {curve.stopped_because}")
    return curve


def usable(curve: PushoverCurve, rows: Sequence[RowMisfits]) -> PushoverCurve:
    """Return the curve up to the row before the first that does not fit; as it is where that leaves no live load."""
    first = first_misfit(rows)
    before = [row.number for row in rows if first is not None and row.number < first.number]
    return curve if first is None or len(before) < 2 else curve.up_to(before[-1], _why(first))


def is_cut_short(curve: PushoverCurve, ends: PushoverCurve) -> bool:
    """Return whether the `usable` part of a curve ends before its base shear has fallen: nothing tells a peak then."""
    return ends is not curve and not has_fallen(ends)


def balanced(curve: PushoverCurve, increments: Iterable[Increment]) -> PushoverCurve:
    """Return the curve up to the last static row with which work and energies balance, where its base shear has fallen
    by then; else as it is. increments: of the curve, in order."""
    of_increments = [
        (one.number, one.control_displacement, error, not one.moving) for one, error in with_energy_errors(increments)
    ]
    number, moved, errors, static = map(np.array, zip(*of_increments, strict=True))
    of_curve = (number > curve.step[0]) & (number <= curve.step[-1])
    fits = np.flatnonzero(of_curve & static & (errors <= ENERGY))
    if not fits.size or not errors[of_curve][-1] > ENERGY:  # what is not a number is no jump
        return curve
    last = fits[-1]
    start, end = 1e3 * (moved[[last, last + 1]] - curve.control_displacement_m[0])
    missing = f"{errors[last + 1]:.2e} (at most {ENERGY:g}) {MISSING}"
    ends = curve.up_to(int(number[last]), f"the curve ends at {start:.4g} mm: on the way to {end:.4g} mm {missing}")
    return ends if has_fallen(ends) else curve


def used(rows: Sequence[RowMisfits], curve: PushoverCurve) -> list[RowMisfits]:
    """Return the misfits of the rows that a curve still has."""
    return [row for row in rows if row.number <= curve.step[-1]]


def largest(rows: Sequence[RowMisfits]) -> dict[str, Any]:
    """Return the largest overlap and the largest pressed gap of rows, in m and over the smaller body's size; 0 of no
    rows. Keys: those of PushoverSummary."""
    both = {"max_penetration": [row.overlap for row in rows], "max_pressed_gap": [row.pressed_gap for row in rows]}
    found: dict[str, float] = {}
    for name, misfits in both.items():
        found[name] = float(np.max([0.0, *(one.distance for one in misfits)]))
        found[f"{name}_over_size"] = float(np.max([0.0, *(one.share for one in misfits)]))
    return found


def _why(first: RowMisfits) -> str:
    """Return why a curve ends before its first row that does not fit."""
    deep = not first.overlap.share <= OVERLAP
    misfit, bound = (first.overlap, OVERLAP) if deep else (first.pressed_gap, APART)
    what = said_of(misfit, "overlap" if deep else "press each other across a gap")
    size = f"{misfit.share:.2e} of the smaller one's size (at most {bound:g})"
    return f"the curve ends before {1e3 * first.moved:.4g} mm: from there on {what}, {size}"
