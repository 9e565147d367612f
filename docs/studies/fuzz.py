"""Coverage-guided fuzzing of the readers (atheris, which is no dependency: pip install atheris).

    python docs/studies/fuzz.py json|toml|dxf SECONDS

Whatever bytes a file holds, a reader returns, or raises CaseError: anything else ends the run with the input that did
it. Findings and executions are in fuzzing.md.
"""

from __future__ import annotations

import sys
import tempfile
from pathlib import Path

import atheris

with atheris.instrument_imports(
    include=["orchestrator.masonry", "orchestrator.settings.case", "orchestrator.settings.sections", "ezdxf", "tomllib"]
):
    from orchestrator.masonry.sources.block_files import read_blocks
    from orchestrator.masonry.sources.closed_outlines import Layers
    from orchestrator.masonry.sources.drawing import HealingSettings, Material, wall_of
    from orchestrator.masonry.sources.dxf import read_dxf
    from orchestrator.settings import case as cases

from orchestrator.basis.errors import CaseError
from orchestrator.masonry.joints import JointSettings, check_assemblage, find_joints
from orchestrator.masonry.wall import Wall, check_wall

DATA = Path(__file__).parents[2] / "tests" / "data"


def walls(path: Path) -> Wall:
    """Read a block file."""
    return read_blocks(path)


def settings(path: Path) -> None:
    """Read a case file that points to a good block file."""
    cases.read(path, [])


def drawings(path: Path) -> Wall:
    """Read a drawing as `import` does."""
    return wall_of(read_dxf(path, Layers(), 1e-3, ""), "wall", Material(thickness=0.3), HealingSettings())[0]


READERS = {"json": walls, "toml": settings, "dxf": drawings}


def seed(kind: str, folder: Path) -> bytes:
    """Return a small good file to start from."""
    if kind == "json":
        return (DATA / "tower_5_blocks.json").read_bytes()
    if kind == "toml":
        (folder / "wall.json").write_bytes((DATA / "tower_5_blocks.json").read_bytes())
        return b'[wall]\nblocks = "wall.json"\nfriction = 0.5\n[mesh]\nsize = "100 mm"\n[load]\ndirection = "-x"\n'
    import ezdxf

    document = ezdxf.new("R12")
    document.header["$INSUNITS"] = 4
    space = document.modelspace()
    space.add_polyline2d([(0, 0), (500, 0), (500, 300), (0, 300)], close=True, dxfattribs={"layer": "blocks"})
    document.saveas(folder / "seed.dxf")
    return (folder / "seed.dxf").read_bytes()


def main(kind: str, seconds: str) -> None:
    """Fuzz one reader for so many seconds."""
    folder = Path(tempfile.mkdtemp())
    (folder / "corpus").mkdir()
    (folder / "corpus" / "seed").write_bytes(seed(kind, folder))
    file = folder / f"wall.{kind}"

    def once(content: bytes) -> None:
        file.write_bytes(content)
        try:
            wall = READERS[kind](file)
            if wall is not None:
                check_wall(wall)
                check_assemblage(find_joints(wall, JointSettings()))
        except CaseError as error:
            if len(str(error).splitlines()) != 1:
                raise AssertionError("more than one line") from error

    options = [f"-max_total_time={seconds}", "-timeout=20", "-rss_limit_mb=2000", "-print_final_stats=1"]
    atheris.Setup([sys.argv[0], str(folder / "corpus"), *options, f"-artifact_prefix={folder}/"], once)
    atheris.Fuzz()


if __name__ == "__main__":
    main(*sys.argv[1:3])
