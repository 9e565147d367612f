"""SIGKILL at random times during a run, then --resume: is the curve the uninterrupted one?

    python docs/studies/killed.py [kills on one rank] [kills on two ranks]

writes killed.md beside this file. Times are drawn between the start of Python and the end of the uninterrupted run; a
killed run is resumed, and every third one is killed a second time before it may finish. On two ranks both share every
linear system; what they sum in another order is within the solver's tolerance.
"""

from __future__ import annotations

import sys
import tempfile
from pathlib import Path
from time import perf_counter

import numpy as np

sys.path.insert(0, str(Path(__file__).parents[2]))

from tests.support.killing import PROJECT, curve, difference, killed_after, moment, run

FOLDER = Path(__file__).parent
MODEL = "macro"
WALL = PROJECT / "tests" / "data" / "ferris_tinloi_wall1.json"
RUN = ["run", str(WALL), "--model", MODEL, "--set", "stepping.final_displacement=2mm"]
SHARED = ["--set", "newton.distribute_above=0"]
BOUND = {1: 1e-10, 2: 1e-8}
HEAD = """# Killed at any moment

`docs/studies/killed.py` (part of `make verify`): macroblock FE of wall 1 of Ferris and Tin-Loi is killed (SIGKILL) at
random times, resumed with `--resume`, and its curve compared with the uninterrupted one. A difference is the largest of
multiplier, base shear, displacement and energies, over the largest value of each. Files of the exact kind, at which a
run is killed while it is about to rename them, are in `tests/verification/test_killed.py`; benchmark 1 is in
[killed_benchmark1.md](killed_benchmark1.md).

| ranks | killed after (s) | while it was | difference |
| ---: | ---: | --- | ---: |
"""


def killed_and_resumed(seconds: list[float], ranks: int, expected: np.ndarray, cache: Path) -> tuple[str, float]:
    """Return what the run was doing at each kill, and how far its curve is from the uninterrupted one."""
    more = SHARED if ranks > 1 else []
    doing = []
    with tempfile.TemporaryDirectory() as folder:
        output = [*more, "--output", folder]
        for number, after in enumerate(seconds):
            killed_after([*RUN, *output, *["--resume"][:number]], cache, after, ranks)
            doing.append(moment(Path(folder), MODEL))
        done = run([*RUN, *output, "--resume"], cache, ranks)
        assert done.returncode == 0, done.stderr
        return ", then ".join(doing), difference(curve(Path(folder), MODEL), expected)


def main(serial: int = 20, shared: int = 6) -> int:
    """Write the table; return 1 if a curve differs."""
    random = np.random.default_rng(7)
    rows, worst = [], {1: 0.0, 2: 0.0}
    with tempfile.TemporaryDirectory() as name:
        cache = Path(name) / "cache"
        for ranks, kills in ((1, serial), (2, shared)):
            whole = Path(name) / f"whole{ranks}"
            more = SHARED if ranks > 1 else []
            run([*RUN, *more, "--output", str(whole)], cache, ranks)
            began = perf_counter()
            done = run([*RUN, *more, "--output", str(whole)], cache, ranks)
            assert done.returncode == 0, done.stderr
            lasts, expected = perf_counter() - began, curve(whole, MODEL)
            for number in range(kills):
                times = sorted(random.uniform(0.15 * lasts, lasts, 2 if number % 3 == 2 else 1), reverse=True)
                doing, off = killed_and_resumed(times, ranks, expected, cache)
                worst[ranks] = max(worst[ranks], off)
                rows.append(f"| {ranks} | {', '.join(f'{t:.2f}' for t in times)} | {doing} | {off:.1e} |")
                print(rows[-1], flush=True)
    (FOLDER / "killed.md").write_text(HEAD + "\n".join(rows) + "\n")
    return int(any(worst[ranks] > BOUND[ranks] for ranks in worst))


if __name__ == "__main__":
    raise SystemExit(main(*map(int, sys.argv[1:])))
