"""What `make setup` installs from each system's packages, and what is left out where a system lacks it."""

from __future__ import annotations

import re
import subprocess

import pytest

from tests.support.paths import PROJECT


@pytest.mark.parametrize(
    ("system", "absent"),
    [
        ("ID=debian\nVERSION_CODENAME=bookworm\n", set()),
        ("ID=debian\nVERSION_CODENAME=trixie\n", {"calculix-ccx"}),
        ("ID=ubuntu\nVERSION_CODENAME=noble\nID_LIKE=debian\n", {"chromium", "chromium-driver"}),
    ],
)
def test_packages_that_a_system_lacks_are_not_asked_for(system, absent, tmp_path):
    """Ubuntu's Chromium is a snap: in a container its package does not install, and nothing else would."""
    release = tmp_path / "os-release"
    release.write_text(system)
    command = ["make", "-n", "-B", "setup", f"OS_RELEASE={release}"]
    shown = subprocess.run(command, cwd=PROJECT, capture_output=True, text=True, check=True).stdout
    asked = re.search(r"apt-get install [^\n]*--no-install-recommends ([^;]*);", shown.replace("\\\n", " "))
    assert asked
    whole = set((PROJECT / "apt-packages.txt").read_text().split())
    assert set(asked[1].split()) == whole - absent
