"""Hook of mkdocs: the settings reference is written from the settings themselves at every build, and stored nowhere.

The file of that name in the repository says so, and how to print them.
"""

from typing import Any

from mkdocs.structure.files import File, Files

from orchestrator.settings.reference import reference_page


def on_files(files: Files, *, config: Any) -> Files:
    """Put the reference in the place of settings.md."""
    if (said := files.get_file_from_path("settings.md")) is not None:
        files.remove(said)
    files.append(File.generated(config, "settings.md", content=reference_page()))
    return files
