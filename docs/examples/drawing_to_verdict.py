"""From a drawing to a verdict: a notebook in percent format, run by the tests."""

# %% [markdown]
# # From a drawing to a verdict
#
# A notebook in percent format: Jupyter (with jupytext), VS Code and Spyder open it as cells, `python` runs it as it is.
# Wanted: a portal of two piers, 0.5 m x 1 m, under a lintel of 0.3 m that spans both. Both piers rock and the lintel
# rides on them: with piers of weight P each and a lintel of L, lambda = b/h (P + L)/(P + L) = b/h = 0.5 for stones of
# any weight (virtual work: every pier lifts P by b/2 and pushes it by h/2; the lintel is lifted by b and pushed by h).

# %%
import json
import sys
from pathlib import Path
from tempfile import mkdtemp
from typing import Any

import ezdxf

from orchestrator.app.cli import main as orchestrator
from orchestrator.app.intake import import_wall, write_wall


# %% [markdown]
# ## The drawing: closed outlines on two layers, in metres
# %%
def drawing(path: Path) -> Path:
    """Draw the portal and its ground as a DXF."""
    document = ezdxf.new()
    document.header["$INSUNITS"] = 6
    outlines = {
        "supports": [((-1, -0.5), (3, 0))],
        "blocks": [((0, 0), (0.5, 1)), ((1.5, 0), (2, 1)), ((0, 1), (2, 1.3))],
    }
    for layer, boxes in outlines.items():
        for (left, bottom), (right, top) in boxes:
            corners = [(left, bottom), (right, bottom), (right, top), (left, top)]
            document.modelspace().add_lwpolyline(corners, close=True, dxfattribs={"layer": layer})
    document.saveas(path)
    return path


# %% [markdown]
# ## Import, case file, run; everything a person would do at the terminal
# %%
CASE = """
name = "Portal"
[project]
client = "An example"
author = "A reader"
[wall]
blocks = "portal.json"
[load]
envelope = true
[mesh]
size = "500 mm"
[run]
models = ["macro"]
[stepping]
final_displacement = "30 mm"
[seismic]
peak_ground_acceleration = "0.1 g"
"""


def main(folder: Path | None = None) -> dict[str, Any]:
    """Return multipliers by load case, the verdict's rows, and the folder with the report."""
    folder = folder or Path(mkdtemp())
    options = {"thickness": "500 mm", "friction": "0.8"}  # unit weight: 20 kN/m3 is the default
    taken = import_wall(drawing(folder / "portal.dxf"), options)
    write_wall(taken, folder / "portal.json")
    (folder / "portal.toml").write_text(CASE, encoding="utf-8")
    code = orchestrator(["run", str(folder / "portal.toml"), "--output", str(folder / "run"), "--quiet"])
    cases = json.loads((folder / "run" / "load_cases.json").read_text(encoding="utf-8"))["load_cases"]
    summaries = {
        case["name"]: json.loads((folder / "run" / case["name"] / "summary.json").read_text(encoding="utf-8"))
        for case in cases
    }
    multipliers = {name: found["limit_analysis"]["non_associative"] for name, found in summaries.items()}
    rows = (folder / "run" / "verdict.csv").read_text(encoding="utf-8").splitlines()
    return {"code": code, "multipliers": multipliers, "verdict": rows, "report": folder / "run" / "report.html"}


# %%
if __name__ == "__main__":
    answer = main()
    sys.stdout.write(f"{answer['multipliers']}\n" + "\n".join(answer["verdict"]) + f"\n{answer['report']}\n")
