"""What pyproject.toml cannot say: a wheel knows its commit, and has the walls and cases of templates/ and meshes/."""

from pathlib import Path
from shutil import copy2
from subprocess import PIPE, run

from setuptools import setup
from setuptools.command.build_py import build_py

ROOT = Path(__file__).parent
SHIPPED = ("templates/*.toml", "templates/*.txt", "templates/study.slurm", "meshes/*.json")


class BuildPackage(build_py):
    """Copy the package, then what goes with it."""

    def run(self) -> None:
        """Do nothing more for an editable install: its sources are a clone."""
        super().run()
        if self.editable_mode:
            return
        package = Path(self.build_lib) / "orchestrator"
        for pattern in SHIPPED:
            for file in ROOT.glob(pattern):
                target = package / "shipped" / file.relative_to(ROOT)
                target.parent.mkdir(parents=True, exist_ok=True)
                copy2(file, target)
        if (ROOT / ".git").exists():
            described = run(
                ["git", "-C", str(ROOT), "describe", "--always", "--exclude=*", "--abbrev=12", "--dirty=+changes"],
                stdout=PIPE, text=True, check=False,
            )  # fmt: skip
            (package / "commit.txt").write_text(described.stdout.strip() + "\n", encoding="ascii")


setup(cmdclass={"build_py": BuildPackage})
