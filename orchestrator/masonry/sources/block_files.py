"""Block files (JSON) -> Wall.

    {"name": "...", "units": {"length": "m", "unit_weight": "kN/m3"}, "thickness": 0.1, "unit_weight": 25.0,
     "friction": 0.65, "blocks": [{"id": 1, "polygon": [[x, y], ...], "fixed": false}, ...]}

Numbers are in the file's own units; polygons are made counter-clockwise. A block may have its own unit_weight (the
wall needs none where all have), and a material: a name that the joint classes of a case refer to. "mortar":
[[id, id, thickness], ...] says how thick the joints between two blocks were drawn.
"""

from __future__ import annotations

import difflib
import json
import stat
import unicodedata
from os import PathLike
from pathlib import Path
from typing import Any

import numpy as np
import shapely

from orchestrator.basis.arrays import FloatArray, read_only
from orchestrator.basis.errors import CaseError, naming
from orchestrator.basis.units import Unit
from orchestrator.geometry.ring_geometry import Spike, clicked_once, without_spikes
from orchestrator.masonry.sources.mended_outlines import said_of_spikes
from orchestrator.masonry.wall import ROUNDING, Block, MortarGap, Wall

UNIT_OF = {"length": Unit("m"), "unit_weight": Unit("N/m3")}
REQUIRED = ("units", "thickness", "friction", "blocks")
INFORMATION = (
    "name", "source", "licence", "license", "remark", "load", "expected", "free_blocks", "interfaces", "weight_kN",
)  # fmt: skip
"""keys that may stand in a block file without changing the wall"""
OPTIONAL = ("unit_weight", "mortar")
BLOCK_KEYS = ("id", "polygon", "fixed", "unit_weight", "material")
ALL_KEYS = "docs/your_wall.md, 'Block files', lists every key with an example"
LARGEST_FILE = 200_000_000
"""bytes; a wall of 100,000 blocks has about 10 MB"""

LARGEST_COORDINATE = 1e100
"""areas of larger blocks overflow"""


def read_blocks(path: str | PathLike[str]) -> Wall:
    """Return the wall in the block file `path`, in SI units. Raises CaseError naming file, key and remedy.

    The wall's shapes are not checked here: see wall.check_wall.
    """
    path = Path(path)
    with naming(path):
        return wall_from(_record(path), path.stem)


def json_in(path: Path, kind: str, largest: int, remedy: str) -> Any:
    """Return what the JSON file `path` holds; `kind` is what it should be, `remedy` what helps if it is not. Raises
    CaseError."""
    try:
        refuse_what_is_no_file(path, largest, remedy)
        return json.loads(path.read_text(encoding="utf-8-sig"), object_pairs_hook=_each_key_once)
    except FileNotFoundError:
        raise CaseError("", "no such file", f"give the path of {kind}") from None
    except (OSError, UnicodeDecodeError) as error:
        raise unreadable(error, f"give the path of {kind}") from None
    except (ValueError, RecursionError) as error:  # not only JSONDecodeError: numbers of 5000 digits, NUL in a path
        raise CaseError("", f"is not JSON ({str(error)[:100]})", remedy) from None


def _each_key_once(pairs: list[tuple[str, Any]]) -> dict[str, Any]:
    """Return a JSON object. Raises CaseError for a key that it has twice: one of its values would be lost."""
    record = dict(pairs)
    if len(record) < len(pairs):
        twice = next(key for n, (key, _) in enumerate(pairs) if key in dict(pairs[:n]))
        raise CaseError(f'"{twice}"', "is given twice in one object", "keep one of them")
    return record


def _record(path: Path) -> dict[str, Any]:
    record = json_in(path, "a JSON block file", LARGEST_FILE, ALL_KEYS)
    if not isinstance(record, dict):
        raise CaseError("", "is not a block file", 'it must be an object with "blocks"')
    return record


def wall_from(record: dict[str, Any], name: str) -> Wall:
    """Return the wall that a block file's content describes, `name` where it has none itself. Raises CaseError."""
    refuse_unknown(record, (*REQUIRED, *OPTIONAL, *INFORMATION), "")
    if record.get("blocks") == []:
        raise CaseError("blocks", "there are none", "list the blocks, each with id and polygon, and a support")
    for key in REQUIRED:
        if key not in record:
            raise CaseError(key, "is missing", ALL_KEYS)
    length, weight = (unit_factor(record["units"], kind) for kind in ("length", "unit_weight"))
    unit_weight = number_in(record, "unit_weight", "") * weight if "unit_weight" in record else None
    if not isinstance(record["blocks"], list):
        raise CaseError("blocks", "is not a list", "list the blocks, each with id and polygon")
    name = record.get("name", name)
    refuse_what_is_no_name(name, "name")
    read = [_block(row, number, unit_weight, length, weight) for number, row in enumerate(record["blocks"])]
    blocks = tuple(block for block, _ in read)
    return Wall(
        name=name,
        blocks=blocks,
        thickness=number_in(record, "thickness", "") * length,
        friction=number_in(record, "friction", ""),
        mortar=_mortar(record.get("mortar", []), {block.id for block in blocks}, length),
        remarks=tuple(remark for _, said in read for remark in said),
    )


def _mortar(rows: Any, known: set[int], length: float) -> tuple[MortarGap, ...]:
    """Return the thicknesses of joints, [[id, id, thickness], ...] in the file's unit `length` (m)."""
    example = "write [[1, 2, 0.01]]: two blocks that exist, and what was between them"
    if not isinstance(rows, list):
        raise CaseError("mortar", "is not a list", example)
    gaps = list[MortarGap]()
    for number, row in enumerate(rows):
        if (
            not isinstance(row, list)
            or len(row) != 3
            or not all(type(part) is int and part in known for part in row[:2])
            or row[0] == row[1]
        ):
            raise CaseError(f"mortar[{number}]", f"{str(row)[:60]} does not name two blocks", example)
        thickness = number_in(dict(thickness=row[2]), "thickness", f"mortar[{number}].") * length
        if thickness <= 0:
            raise CaseError(f"mortar[{number}].thickness", f"{row[2]:g} is not above 0", example)
        i, j = sorted(row[:2])
        if any((one.i, one.j) == (i, j) for one in gaps):
            raise CaseError(f"mortar[{number}]", f"blocks {i} and {j} are given twice", "give every pair once")
        gaps.append(MortarGap(i, j, thickness))
    return tuple(gaps)


def unit_factor(units: Any, kind: str) -> float:
    """Return what a file's unit of length or of unit weight is in SI. Raises CaseError."""
    if not isinstance(units, dict) or kind not in units:
        raise CaseError(f"units.{kind}", "is missing", f'state the unit, as in "{kind}": "{UNIT_OF[kind].symbol}"')
    refuse_unknown(units, tuple(UNIT_OF), "units.")
    try:
        return UNIT_OF[kind].factor(str(units[kind]))
    except ValueError as error:
        problem, _, remedy = str(error).partition("; ")
        raise CaseError(f"units.{kind}", problem, remedy) from None


def _block(row: Any, number: int, unit_weight: float | None, length: float, weight: float) -> tuple[Block, list[str]]:
    """Return a block, and what is to be said of its outline."""
    number_of_block, fixed, own, material = what_every_block_has(row, number, BLOCK_KEYS, unit_weight, weight)
    polygon, spikes = _outline(row, number_of_block)
    spikes = [Spike((spike.tip[0] * length, spike.tip[1] * length), spike.length * length) for spike in spikes]
    block = Block(number_of_block, polygon * length, fixed, own, material)
    return block, said_of_spikes(f"the outline of block {block.id}", block.polygon, spikes)


def what_every_block_has(
    row: Any, number: int, known: tuple[str, ...], unit_weight: float | None, weight: float
) -> tuple[int, bool, float, str]:
    """Return id, whether it is a support, unit weight (N/m3) and material of the block in row `number`, which may have
    the keys `known`. unit_weight: the file's own, N/m3, or None; weight: the file's unit of it. Raises CaseError."""
    if not isinstance(row, dict) or type(row.get("id")) is not int:
        raise CaseError(f"blocks[{number}].id", "is missing or not a whole number", "give every block its own id")
    key = f"block {row['id']}"
    refuse_unknown(row, known, f"{key}.")
    fixed, material = row.get("fixed", False), row.get("material", "")
    if not isinstance(fixed, bool):
        raise CaseError(f"{key}.fixed", f"{fixed!r} is neither true nor false", "write true for supports")
    refuse_what_is_no_name(material, f"{key}.material")
    own = number_in(row, "unit_weight", f"{key}.") * weight if "unit_weight" in row else unit_weight
    if own is None:
        raise CaseError("unit_weight", f"is missing, and {key} has none", "give the wall one, or every block its own")
    return row["id"], fixed, own, material


def polygon_of(row: dict[str, Any], number: int) -> FloatArray:
    """Return the corners (n, 2) of a block, in the file's units, counter-clockwise, without those that the next one
    repeats but for rounding (of numbers; of a drawing where it would cross itself there), and from which the outline
    goes back on itself. Raises CaseError."""
    return _outline(row, number)[0]


def _outline(row: dict[str, Any], number: int) -> tuple[FloatArray, list[Spike]]:
    """Return the corners of a block as `polygon_of` does, and where its outline went back on itself."""
    key = f"block {number}"
    try:
        polygon = np.array(row.get("polygon"))
    except ValueError:
        polygon = np.zeros(0)
    if polygon.dtype.kind not in "if" or polygon.ndim != 2 or polygon.shape[1] != 2 or len(polygon) < 3:
        raise CaseError(
            f"{key}.polygon", "is not a list of at least three corners [x, y]", "write [[x, y], [x, y], [x, y]]"
        )
    if not (np.abs(polygon) < LARGEST_COORDINATE).all():
        raise CaseError(f"{key}.polygon", "a coordinate is not a finite number", "give finite coordinates")
    polygon = polygon.astype(float)
    side = np.abs(polygon - np.roll(polygon, -1, axis=0)).max(axis=1)
    rounding = 1e-12 * float(side.max())
    if np.count_nonzero(side > rounding) < 3:
        raise CaseError(f"{key}.polygon", "has fewer than three different corners", "list every corner once")
    polygon, size = polygon[side > rounding], float(np.sqrt(np.prod(np.ptp(polygon, axis=0))))
    if side.min() <= ROUNDING * size and not shapely.Polygon(polygon).is_valid:
        polygon = clicked_once(polygon, ROUNDING * size)
    polygon, spikes = without_spikes(polygon, rounding)
    x, y = polygon.T
    doubled_area = np.sum(x * np.roll(y, -1) - np.roll(x, -1) * y)
    return read_only(polygon if doubled_area > 0 else polygon[::-1]), spikes


def number_in(record: dict[str, Any], key: str, place: str) -> float:
    """Return a number of a record, in the file's units. Raises CaseError, before whose key stands `place`."""
    value = record[key]
    if isinstance(value, bool) or not isinstance(value, int | float) or not abs(value) < 1e300:
        raise CaseError(place + key, f"{value!r} is not a number", "write a number in the file's units")
    return float(value)


def refuse_what_is_no_file(path: Path, largest: int, remedy: str) -> None:
    """Raise CaseError for a file of more than `largest` bytes and for what has no end, as a pipe or a device."""
    status = path.stat()
    if not stat.S_ISREG(status.st_mode) and not stat.S_ISDIR(status.st_mode):
        raise CaseError("", "is no file but a pipe or a device", "save what it gives to a file first")
    if status.st_size > largest:
        raise CaseError("", f"larger than {largest / 1e6:g} MB", remedy)


def unreadable(error: OSError | UnicodeDecodeError, remedy: str) -> CaseError:
    """Return the complaint about a file that is a folder, is no UTF-8, or cannot be read for another reason."""
    if isinstance(error, UnicodeDecodeError):
        line = error.object[: error.start].count(b"\n") + 1
        problem = f"is not UTF-8 text (byte {error.object[error.start]:#04x} in line {line})"
        return CaseError("", problem, "save it as UTF-8")
    if isinstance(error, IsADirectoryError):
        return CaseError("", "is a folder", remedy)
    return CaseError("", f"cannot be read ({error.strerror or error})", remedy)


def refuse_what_is_no_name(text: object, key: str) -> None:
    """Raise CaseError for what is no text, or one that no file or picture can hold."""
    if not isinstance(text, str):
        raise CaseError(key, f"{str(text)[:60]} is not a name", 'write a text, in "quotes"')
    refuse_what_is_not_utf8(text, key)
    if any(unicodedata.category(letter) == "Cc" and not letter.isspace() for letter in text):
        raise CaseError(key, f"{text!r:.60} has a control character", "leave it out")


def refuse_what_is_not_utf8(text: str, key: str) -> None:
    """Raise CaseError for a text that no output file can hold, as a file name from another system may be."""
    try:
        text.encode()
    except UnicodeEncodeError:
        raise CaseError(key, f"{text!r} is not UTF-8", "rename it") from None


def refuse_unknown(record: dict[str, Any], known: tuple[str, ...], place: str) -> None:
    """Raise CaseError for a key of a record that is not known."""
    for key in record:
        if key not in known:
            near = difflib.get_close_matches(key, known, 1)
            remedy = f"did you mean {near[0]}?" if near else f"known keys are {', '.join(known)}"
            raise CaseError(place + key, "is not a known key", remedy)
