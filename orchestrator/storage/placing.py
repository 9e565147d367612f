"""Results of limit, segment, study and sensitivity: they take their places all at once, and those of before go then.

results.json says what they are of, and names every file with its sha256. What goes is what was named there and has not
been changed since (clearing.py): a file of somebody else is never one of these, whatever it is called.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from orchestrator.basis.atomic_files import locked, sweep, together
from orchestrator.basis.errors import CaseError
from orchestrator.storage.clearing import (
    RECORD,
    clear_run,
    files_of_a_run,
    named_in,
    read_record,
    remove_named,
    remove_recorded,
)
from orchestrator.storage.files import hash_file, plain, write_json
from orchestrator.storage.outputs import refuse_input, refuse_overwriting_run


@dataclass(frozen=True, eq=False, slots=True)
class Source:
    """What results are of: the command, the settings of its case, and the files that these are in.

    points: hash of all that a study or a sensitivity analysis has run; "" of other commands.
    """

    command: str
    settings: Mapping[str, Any]
    files: tuple[Path, ...]
    points: str = ""

    @property
    def record(self) -> dict[str, Any]:
        """What results.json says of it."""
        hashes = {str(path): hash_file(path) for path in self.files if path.is_file()}
        points = {"points_sha256": self.points} if self.points else {}
        return {"command": self.command, "settings": plain(self.settings), "sha256": hashes} | points


@contextmanager
def held(*folders: Path, force: bool, run_of: Iterable[Path] | None = None) -> Iterator[None]:
    """Hold folders for this process alone. Raises CaseError where another one does, and, unless by `force`, where one
    has the results of a run or study: nobody writes them between the question and the end.

    run_of: what a run reads, which writes there as it goes on: these files, and those that no command has left whole,
    are refused before.
    """
    with locked(*folders):
        for folder in () if force else folders:
            refuse_overwriting_run(folder, resumable=run_of is not None)
            if run_of is not None:
                refuse_input(files_of_a_run(folder), run_of)
                _refuse_foreign(files_of_a_run(folder), (folder.parent, *folders), "go on with --resume, ")
        yield


@contextmanager
def placed(folders: Sequence[Path], source: Source, force: bool) -> Iterator[None]:
    """Let what is written inside take its place at the end, and what the program has left in the folders go then.

    folders: all that is written into; the first one holds the others, and results.json. force: results of runs go too,
    and so do files that no command has left. Without it one of these in the place of a result raises CaseError at the
    end, and nothing changes: only then it is known what takes a place.
    """
    folder, *others = dict.fromkeys(folders)
    sweep(*(part for one in folders for part in (one, one / "figures")))
    named: dict[str, str] = {}

    def prepare(files: Mapping[Path, Path]) -> None:
        """Make room. Killed from here on a command leaves a part of its results, and the names of all."""
        written = (*files, folder / RECORD)
        refuse_input(written, source.files)
        if not force:
            _refuse_foreign(written, (folder.parent, folder, *others))
        inside = {path: temporary for path, temporary in files.items() if path.is_relative_to(folder)}
        named.update({path.relative_to(folder).as_posix(): hash_file(temporary) for path, temporary in inside.items()})
        earlier = named_in(read_record(folder))
        write_json(folder / RECORD, source.record | {"files": named, "earlier": earlier})
        remove_named(folder, earlier, source.files)
        for one in others:
            remove_recorded(one, source.files)
        for one in (folder, *others) if force else ():
            clear_run(one, source.files)

    with together(prepare):
        yield
    write_json(folder / RECORD, source.record | {"files": named})


def _refuse_foreign(files: Iterable[Path], folders: Iterable[Path], other: str = "") -> None:
    """Raise CaseError where a result would take the place of a file that no command has left as it is.

    other: what else the user may do.
    """
    records = {one: read_record(one) for one in folders}
    left = {(one / name, digest) for one, record in records.items() for name, digest in named_in(record)}
    left |= {(one / RECORD, hash_file(one / RECORD)) for one, record in records.items() if "command" in record}
    for path in files:
        if path.is_file() and (path, hash_file(path)) not in left:
            problem = "would be overwritten, and is no result or has been changed since"
            remedy = f"give another folder with --output, {other}or overwrite it with --force"
            raise CaseError("", problem, remedy, str(path))


def refuse_other_points(folder: Path, table: str, source: Source) -> None:
    """Raise CaseError for a folder that holds the table of a study or sensitivity analysis of something else, or
    results of another command."""
    record = read_record(folder)
    if (command := record.get("command", source.command)) != source.command:
        problem = f"holds the results of {command}"
    elif (folder / table).exists() and record.get("points_sha256") != source.points:
        problem = f"holds a {source.command} of other settings, or by another version of the program ({table})"
    else:
        return
    raise CaseError("--output", problem, "give another --output, or overwrite it with --force", str(folder))
