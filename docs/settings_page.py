"""Hook of mkdocs: the settings reference is written from the settings themselves at every build, and stored nowhere."""

from typing import Any

from mkdocs.structure.files import File, Files

from orchestrator.settings.reference import reference_page


def on_files(files: Files, *, config: Any) -> Files:
    """Add settings.md to the pages."""
    files.append(File.generated(config, "settings.md", content=reference_page()))
    return files
