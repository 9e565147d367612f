"""Headless Chromium for the pages that the program writes; tests that use it are skipped where it is not installed."""

from __future__ import annotations

import json
import shutil
from collections.abc import Iterator
from contextlib import contextmanager
from typing import Any

import pytest

webdriver = pytest.importorskip("selenium.webdriver")
pytest.importorskip("selenium.webdriver.support.wait")
CHROMIUM, DRIVER = shutil.which("chromium"), shutil.which("chromedriver")
if not (CHROMIUM and DRIVER):
    pytest.skip("needs Debian's chromium and chromium-driver", allow_module_level=True)


@contextmanager
def headless() -> Iterator[Any]:
    """A browser that keeps its messages and what it asked for."""
    options = webdriver.ChromeOptions()
    options.binary_location = CHROMIUM
    for argument in ("--headless=new", "--no-sandbox", "--disable-gpu", "--disable-dev-shm-usage"):
        options.add_argument(argument)
    options.set_capability("goog:loggingPrefs", {"browser": "ALL", "performance": "ALL"})
    driver = webdriver.Chrome(options=options, service=webdriver.ChromeService(DRIVER))
    try:
        yield driver
    finally:
        driver.quit()


def opened(page: Any, address: str) -> Any:
    """The browser when it shows the whole page: on a loaded machine `get` may return while the page before is there."""
    page.get("about:blank")
    page.get(address)
    whole = "return location.href !== 'about:blank' && document.readyState === 'complete'"
    webdriver.support.wait.WebDriverWait(page, 60).until(lambda p: p.execute_script(whole))
    return page


def asked(page: Any) -> list[str]:
    """Addresses that were asked for since the last call."""
    messages = [json.loads(entry["message"])["message"] for entry in page.get_log("performance")]
    return [m["params"]["request"]["url"] for m in messages if m["method"] == "Network.requestWillBeSent"]


def awaited(page: Any, selector: str) -> list[Any]:
    """Elements that a CSS selector finds, as soon as there is one."""
    return webdriver.support.wait.WebDriverWait(page, 60).until(lambda p: p.find_elements("css selector", selector))


def set_slider(page: Any, value: int) -> None:
    """Move the slider of a report to a value, to its end where that is larger."""
    script = "const s = document.getElementById('slider'); s.value = arguments[0]; s.dispatchEvent(new Event('input'));"
    page.execute_script(script, value)


def picture(page: Any) -> list[str]:
    """Path of the first body, place of the point, and the line that says where we are."""
    return page.execute_script(
        "return [document.querySelector('#picture .body').getAttribute('d'),"
        " document.getElementById('point').getAttribute('cx'), document.getElementById('state').textContent]"
    )
