"""Time of import and check against the number of stones: python benchmarks/import.py

Walls of irregular courses, drawn as closed polylines in mm, corners off by up to 0.4 mm; import closes gaps and
overlaps and draws the numbered wall, check solves two linear programs. CPU seconds of this process.
"""

from __future__ import annotations

import sys
from pathlib import Path
from tempfile import TemporaryDirectory
from time import process_time

PROJECT = Path(__file__).parents[1]
sys.path.insert(0, str(PROJECT))

from orchestrator.app import driver
from orchestrator.app.intake import import_wall, write_wall
from orchestrator.masonry.patterns import IrregularCourses, irregular_courses
from orchestrator.settings import case as cases
from tests.support.drawings import polylines


def main() -> None:
    """Print a row for each size."""
    print("stones  joints  import, s  check, s")
    for length in (3.0, 6.0, 7.0, 9.0):
        wall = irregular_courses(IrregularCourses(length, 0.85 * length))
        with TemporaryDirectory() as folder:
            drawn, blocks = polylines(Path(folder) / "wall.dxf", wall, error=4e-4), Path(folder) / "wall.json"
            began = process_time()
            write_wall(import_wall(drawn, {"thickness": "0.3 m", "friction": "0.75"}), blocks)
            imported = process_time()
            case = cases.read(blocks)
            assemblage = driver.check(case)
            driver.examine(case, assemblage)
            joints = assemblage.joints.count
            print(f"{len(wall.blocks) - 1:6d}  {joints:6d}  {imported - began:9.2f}  {process_time() - imported:8.2f}")


if __name__ == "__main__":
    main()
