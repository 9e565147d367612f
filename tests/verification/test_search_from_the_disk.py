"""Search of the documentation in pages opened from the disk: the words are found, and nothing is fetched."""

from __future__ import annotations

import subprocess
import sys

from tests.support.browser import asked, awaited, headless, opened
from tests.support.paths import PROJECT


def test_two_words_lead_to_the_section_on_them(tmp_path):
    built = [sys.executable, "-m", "mkdocs", "build", "--strict", "--site-dir", str(tmp_path)]
    subprocess.run(built, cwd=PROJECT, check=True, capture_output=True, timeout=120)
    with headless() as page:
        page.set_window_size(1280, 900)
        opened(page, (tmp_path / "index.html").as_uri())
        field = page.find_element("css selector", ".md-search__input")
        assert field.is_displayed()
        field.click()
        field.send_keys("mortar crushing")
        found = awaited(page, ".md-search-result__link")
        addresses = [link.get_attribute("href").split("?")[0] for link in found]
        assert (tmp_path / "your_wall.html").as_uri() in [address.split("#")[0] for address in addresses]
        assert all(address.startswith(("file:", "data:")) for address in asked(page))
        assert page.get_log("browser") == []
