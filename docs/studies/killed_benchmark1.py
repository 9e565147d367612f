"""SIGKILL at 20 random times during benchmark 1, as `make benchmark1` runs it, then --resume: is the curve the same?

    python docs/studies/killed_benchmark1.py [kills on one rank] [kills on two ranks]

writes killed_benchmark1.csv and killed_benchmark1.md beside this file. One run is killed, resumed, killed again and so
on; when it ends before all kills are used up, the next chain begins. The curves that a chain ends in are compared with
those of a run that nobody killed.
"""

from __future__ import annotations

import sys
import tempfile
from collections.abc import Iterator
from pathlib import Path
from time import perf_counter

import numpy as np

sys.path.insert(0, str(Path(__file__).parents[2]))

from orchestrator.storage import write_csv, write_text
from tests.support.killing import PROJECT, curve, difference, killed_after, run, stage_of_run

FOLDER = Path(__file__).parent
MODELS = ("macro", "micro")
RUN = ["run", str(PROJECT / "templates" / "benchmark1.toml"), "--quiet"]
COLUMNS = ("ranks", "chain", "killed_after_s", "while_it_was", "macro_difference", "micro_difference")
SHARE = (0.02, 0.35)
"""of the time of an uninterrupted run: a leg of a chain takes so much, drawn evenly"""
LONGEST = 1800.0
"""s any one run may take, on a machine that others use too"""
BOUND = 1e-10
HEAD = """# Benchmark 1 killed twenty times

`docs/studies/killed_benchmark1.py` (part of `make verify`): benchmark 1 as `make benchmark1` runs it, macroblock FE and
micro-FE, is killed (SIGKILL, all ranks) at random times and resumed with `--resume`, again and again, until it ends.
The curves that a chain of killed runs ends in are compared with those of a run that nobody killed: the largest
difference of multiplier, base shear, displacement and energies, over the largest value of each. Times count from the
start of the resumed run, which first does micro limit analysis and the pictures of it again. A wall of this size is
computed by one rank; on two ranks the other one waits, and is killed too. Two ranks that share the linear system are
in [the study of a small wall](killed.md).

| ranks | chain | killed after (s) | while it was | macroblock FE differs by | micro-FE differs by |
| ---: | ---: | ---: | --- | ---: | ---: |
"""


def chain(lasts: float, most: int, ranks: int, cache: Path, random: np.random.Generator) -> tuple[list[str], Path]:
    """Kill a run up to `most` times and let it end; return when, and what it was doing, and its folder."""
    output = cache.parent / f"chain{random.integers(1_000_000_000)}"
    command, kills = [*RUN, "--output", str(output)], []
    while len(kills) < most:
        after, before = random.uniform(*SHARE) * lasts, len(log(output))
        if killed_after([*command, *["--resume"][: len(kills)]], cache, after, ranks) == 0:
            return kills, output
        kills.append((f"{after:.1f}", stage_of_run(output, log(output)[before:])))
        print(*kills[-1], flush=True)
    done = run([*command, "--resume"], cache, ranks, LONGEST)
    assert done.returncode == 0, done.stderr
    return kills, output


def log(output: Path) -> str:
    """Return run.log so far."""
    return (output / "run.log").read_text() if (output / "run.log").exists() else ""


def measured(kills: dict[int, int], folder: Path) -> Iterator[list[str]]:
    """Yield a row for each kill; kills: how many on so many ranks."""
    random = np.random.default_rng(7)
    cache, whole = folder / "cache", folder / "whole"
    began = perf_counter()
    done = run([*RUN, "--output", str(whole)], cache, 1, LONGEST)
    assert done.returncode == 0, done.stderr
    lasts = perf_counter() - began
    print(f"nobody kills it: {lasts:.0f} s", flush=True)
    for ranks, most in kills.items():
        left, number = most, 0
        while left:
            number += 1
            killed, output = chain(lasts, left, ranks, cache, random)
            left -= len(killed)
            off = [f"{difference(curve(output, model), curve(whole, model)):.1e}" for model in MODELS]
            yield from ([str(ranks), str(number), *kill, *off] for kill in killed)


def main(serial: int = 12, together: int = 8) -> int:
    """Write the table; return 1 if a curve differs."""
    rows: list[list[str]] = []
    with tempfile.TemporaryDirectory() as name:
        for row in measured({1: serial, 2: together}, Path(name)):
            rows.append(row)
            write_csv(FOLDER / "killed_benchmark1.csv", COLUMNS, rows)
    write_text(FOLDER / "killed_benchmark1.md", HEAD + "\n".join(f"| {' | '.join(row)} |" for row in rows) + "\n")
    return int(any(not float(off) <= BOUND for row in rows for off in row[-2:]))


if __name__ == "__main__":
    raise SystemExit(main(*map(int, sys.argv[1:])))
