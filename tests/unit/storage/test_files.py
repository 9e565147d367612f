"""Files of a run are whole or absent, its log has what was said, its provenance no secrets."""

from __future__ import annotations

import hashlib
import json
import logging
import sys
from math import inf, nan

import numpy as np
import pytest

from orchestrator import storage
from orchestrator.basis.atomic_files import replacing
from orchestrator.basis.errors import CaseError


def test_a_file_is_replaced_whole_and_nothing_temporary_stays(tmp_path):
    path = tmp_path / "new" / "a.txt"
    storage.write_text(path, "old")
    storage.write_text(path, "µ = 0.65\n")
    assert path.read_bytes() == "µ = 0.65\n".encode()
    assert [p.name for p in path.parent.iterdir()] == ["a.txt"]


def test_an_error_while_writing_leaves_the_older_file_and_no_temporary_one(tmp_path):
    path = tmp_path / "a.txt"
    storage.write_text(path, "old")

    def fails_half_way():
        with replacing(path) as temporary:
            temporary.write_text("half of the n")
            raise OSError("disk full")

    with pytest.raises(OSError, match="disk full"):
        fails_half_way()
    assert path.read_text() == "old"
    assert [p.name for p in tmp_path.iterdir()] == ["a.txt"]


def test_the_target_appears_only_after_everything_is_written(tmp_path):
    path = tmp_path / "a.txt"
    with replacing(path) as temporary:
        temporary.write_text("x")
        assert not path.exists()
        assert temporary.parent == path.parent  # rename must not cross file systems
    assert path.read_text() == "x"


def test_json_turns_numpy_into_plain_values_and_infinity_into_null(tmp_path):
    storage.write_json(tmp_path / "a.json", {"a": np.array([[1, 2]]), "b": (np.float64(0.1), inf, nan), "c": np.True_})
    text = (tmp_path / "a.json").read_text()
    assert json.loads(text) == {"a": [[1, 2]], "b": [0.1, None, None], "c": True}


def test_hash_is_sha256(tmp_path):
    (tmp_path / "a").write_bytes(b"abc")
    assert storage.hash_file(tmp_path / "a") == "ba7816bf8f01cfea414140de5dae2223b00361a396177a9cb410ff61f20015ad"


def test_versions_name_what_is_installed_and_skip_what_is_not(monkeypatch):
    monkeypatch.setitem(storage.files.DISTRIBUTIONS, "absent", "surely-not-installed-anywhere")
    found = storage.versions()
    assert found["numpy"] == np.__version__
    assert {"python", "scipy", "h5py"} <= set(found)
    assert "absent" not in found


def test_run_log_takes_the_package_s_messages_and_lets_go_of_the_logger(tmp_path):
    before = list(logging.getLogger("orchestrator").handlers)
    for message in ("first", "second"):  # a resumed run appends
        with storage.logging_to(tmp_path / "run.log"):
            logging.getLogger("orchestrator.pushover").info(message)
            logging.getLogger("orchestrator.pushover").debug("chatter")
            logging.getLogger("elsewhere").error("other")
    logging.getLogger("orchestrator.pushover").error("too late")
    lines = (tmp_path / "run.log").read_text().splitlines()
    assert [line.rsplit(" ", 3)[1:] for line in lines] == [
        ["INFO", "orchestrator.pushover:", message] for message in ("first", "second")
    ]
    assert logging.getLogger("orchestrator").handlers == before


def test_run_log_ends_with_what_stopped_the_run(tmp_path):
    with pytest.raises(CaseError), storage.logging_to(tmp_path / "run.log"):
        raise CaseError("wall.blocks", "has gone", "bring it back", "case.toml")
    (line,) = (tmp_path / "run.log").read_text().splitlines()
    assert "ERROR" in line
    assert line.endswith("stopped by CaseError: case.toml: wall.blocks: has gone; bring it back")


def test_provenance_tells_command_versions_and_hashes_but_no_secrets(tmp_path, monkeypatch):
    file = tmp_path / "case.toml"
    file.write_text("name = 'x'")
    monkeypatch.setenv("OMP_NUM_THREADS", "1")
    monkeypatch.setenv("MY_PASSWORD", "swordfish")
    told = "\n".join(storage.provenance([file]))
    command = ["python", "-m", "orchestrator", "run", "my wall.toml"]
    monkeypatch.setattr(sys, "orig_argv", command)
    assert storage.provenance([file])[0] == "command: python -m orchestrator run 'my wall.toml'"
    assert "OMP_NUM_THREADS=1" in told
    assert f"numpy {np.__version__}" in told
    digest = hashlib.sha256(b"name = 'x'").hexdigest()  # of the text above
    assert f"sha256 of {file}: {digest}" in told
    assert "swordfish" not in told
