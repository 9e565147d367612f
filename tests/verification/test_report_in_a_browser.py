"""report.html in headless Chromium: no complaint, nothing fetched, a slider that moves the wall, the summary's numbers.

The wall's name, its materials and the case's name are HTML: they must be read, never run.
"""

from __future__ import annotations

import base64
import json
import re
import shutil

import numpy as np
import pytest

from orchestrator import storage
from orchestrator.app.cli import main
from tests.support.browser import asked, awaited, headless, opened, picture, set_slider
from tests.support.paths import PROJECT
from tests.support.undrawn import undrawn

EVIL = "</script><script>document.title = 'run'</script><img src=x onerror=\"document.title='run'\">"


@pytest.fixture(scope="module")
def run(tmp_path_factory):
    folder = tmp_path_factory.mktemp("report")
    wall = json.loads((PROJECT / "tests/data/ferris_tinloi_wall1.json").read_text(encoding="utf-8"))
    wall["name"] = EVIL
    for block in wall["blocks"]:
        block["material"] = EVIL
    (folder / "wall.json").write_text(json.dumps(wall), encoding="utf-8")
    (folder / "case.toml").write_text(
        f"name = {json.dumps(EVIL)}\n[wall]\nblocks = 'wall.json'\n[stepping]\nfinal_displacement = '1 mm'\n"
        "[macroblocks]\ntol_n = 1e-3\n"
        "[seismic]\npeak_ground_acceleration = '0.15 g'\nground = 'B'\n"
        "[[seismic.limit_states]]\nname = 'DL'\npeak_ground_acceleration = '0.06 g'\n"
        "[[seismic.limit_states]]\nname = 'NC'\npeak_ground_acceleration = '0.2 g'\n",
        encoding="utf-8",
    )
    assert main(["run", str(folder / "case.toml"), "--output", str(folder / "run"), "--quiet"]) == 0
    return folder / "run"


@pytest.fixture(scope="module")
def browser():
    with headless() as driver:
        yield driver


@pytest.fixture
def page(run, browser):
    return opened(browser, (run / "report.html").as_uri())


def test_no_error_and_nothing_fetched(page):
    assert page.get_log("browser") == []
    addresses = asked(page)
    assert addresses
    assert all(url.startswith(("file:", "data:")) for url in addresses)


def test_names_from_the_input_are_read_not_run(page):
    assert page.title == f"Pushover assessment: {EVIL}"
    assert page.find_element("tag name", "h1").text == EVIL
    assert EVIL in page.find_element("id", "materials").text  # materials


def test_the_slider_moves_the_wall_and_the_point_of_every_model(page):
    for button in awaited(page, "#models button"):
        button.click()
        most = int(page.execute_script("return document.getElementById('slider').max"))
        assert most > 10
        seen = []
        for value in (0, most // 2, most):
            set_slider(page, value)
            paths = "return [...document.querySelectorAll('#picture .body')].map(path => path.getAttribute('d')).join()"
            seen.append((page.execute_script(paths), *picture(page)[1:]))
        for column in zip(*seen, strict=True):
            assert len(set(column)) == 3
    assert page.get_log("browser") == []


def test_the_drawing_factor_stays_until_the_user_changes_it(page):
    """One factor for every increment of every model, on the switch and in the line of state; 6 % of the height most."""
    stated = set()
    for button in awaited(page, "#models button"):
        button.click()
        most = int(page.execute_script("return document.getElementById('slider').max"))
        for value in range(most + 1):
            set_slider(page, value)
            stated.add(picture(page)[2].rpartition("drawn × ")[2])
    (factor,) = stated
    assert float(factor) > 1
    switch = page.find_element("id", "factor")
    assert page.execute_script("return arguments[0].selectedOptions[0].textContent", switch) == f"{factor} (auto)"
    page.execute_script("arguments[0].value = '50'; arguments[0].dispatchEvent(new Event('change'));", switch)
    set_slider(page, 3)
    assert picture(page)[2].endswith("drawn × 50")


def test_the_wall_is_drawn_where_its_nodes_are(page, run):
    """At the true scale, the last increment: reach of all outlines against the stored displacements, to 0.02 mm."""
    page.execute_script(
        "const f = document.getElementById('factor'); f.value = '1'; f.dispatchEvent(new Event('change'));"
    )
    set_slider(page, 10**6)
    script = "return [...document.querySelectorAll('#picture .body')].map((b) => b.getAttribute('d'))"
    text = "".join(page.execute_script(script)).replace("M", "L").replace("Z", "")
    drawn = np.array([point.split() for point in text.split("L")[1:]], dtype=float) * [1, -1]
    store, meshes, _ = storage.read_geometry(run / "macro")
    moved = meshes.nodes[:, :2] + store.last().displacement[: len(meshes.nodes), :2]
    assert np.ptp(moved[:, 0]) > np.ptp(meshes.nodes[:, 0]) + 1e-3
    np.testing.assert_allclose(drawn.max(axis=0), moved.max(axis=0), atol=2e-5)
    np.testing.assert_allclose(drawn.min(axis=0), moved.min(axis=0), atol=2e-5)


def test_numbers_equal_the_summary(page, run):
    summary = json.loads((run / "summary.json").read_text(encoding="utf-8"))
    shown = page.find_elements("css selector", "[data-key]")
    keys = [cell.get_attribute("data-key") for cell in shown]
    wanted = {
        "seismic.kinematic.a0_star_m_per_s2",
        "seismic.checks.1.safety_ratio",
        "wall.weight",
        "limit_analysis.associative",
        "pushover.0.peak_base_shear",
        "pushover.1.peak_multiplier",
    }
    assert wanted <= set(keys)
    for key, cell in zip(keys, shown, strict=True):
        value = summary
        for part in key.split("."):
            value = value[int(part) if part.isdigit() else part]
        text = cell.get_attribute("textContent")
        expected = value * float(cell.get_attribute("data-factor"))
        rounded = 6e-3 if key.endswith(("seconds", "total", "peak_memory")) else 6e-4
        assert float(text) == pytest.approx(expected, rel=rounded), key


def test_the_state_line_at_the_peak_equals_the_summary(page, run):
    peak = json.loads((run / "summary.json").read_text(encoding="utf-8"))["pushover"][0]
    _, _, text = picture(page)  # the page opens at the peak
    assert f"λ = {peak['peak_multiplier']:.4f}, base shear {peak['peak_base_shear'] / 1e3:.4g} kN" in text


def test_the_page_is_one_small_file_that_prints(page, run):
    assert (run / "report.html").stat().st_size < 5_000_000
    pdf = page.execute_cdp_cmd("Page.printToPDF", {"preferCSSPageSize": True, "printBackground": True})["data"]
    assert pdf.startswith("JVBERi")  # %PDF-


def test_the_seismic_verification_is_one_page_of_a4(page):
    """Everything else hidden, the PDF has one page; its picture, spectrum, clauses and notes are on it."""
    others = "document.querySelectorAll('header, main > :not(#seismic)')"
    page.execute_script(f"for (const other of {others}) other.style.display = 'none'")
    pdf = page.execute_cdp_cmd("Page.printToPDF", {"preferCSSPageSize": True, "printBackground": True})["data"]
    assert len(re.findall(rb"/Type\s*/Page\b", base64.b64decode(pdf))) == 1
    section = page.find_element("id", "seismic")
    assert section.find_element("tag name", "img").get_property("naturalWidth") > 500
    for text in ("EN 1998-1 Annex B", "C8.7.1.2.1.7", "unit weight", "control point", "safety ratio"):
        assert text in section.text, text


LANGUAGES = ("en", "it", "pt")
TEXTS = """
const walker = document.createTreeWalker(document, NodeFilter.SHOW_TEXT), texts = [];
while (walker.nextNode()) {
  const node = walker.currentNode;
  if (!node.parentElement.closest("script, style, #input table, #versions table, td.clause")) texts.push(node.data);
}
for (const name of ["alt", "aria-label"])
  for (const one of document.querySelectorAll(`[${name}]`)) texts.push(one.getAttribute(name));
return texts.map((text) => text.replace(/\\s+/g, " ").trim());
"""
"""what a reader reads of the page, but for clauses, settings as written in a case file, versions and hashes"""
MATERIAL = "</script><script>document.title = 'run'</script><img src=x …"
EQUAL = {EVIL, MATERIAL, "+x mass", "area (m²)", "material", "horizontal (kN)", "vertical (kN)"}
"""what may be equal in two languages: names from the input, a load case by names of settings, shared words"""


@pytest.fixture(scope="module")
def spoken(run, tmp_path_factory):
    """The report of the run in every language, by language."""
    told = {language: tmp_path_factory.mktemp("spoken") / language for language in LANGUAGES[1:]}
    for language, folder in told.items():
        shutil.copytree(run, folder)
        case = folder / "case.toml"
        case.write_text(case.read_text(encoding="utf-8").replace('language = "en"', f'language = "{language}"'))
        with undrawn():
            assert main(["report", str(folder)]) == 0
    return {language: (folder / "report.html").as_uri() for language, folder in {"en": run, **told}.items()}


def read_aloud(browser, address):
    """Every text with a word of three small letters that a reader meets on the page, at rest and while it plays."""
    opened(browser, address)
    texts = browser.execute_script(TEXTS)
    set_slider(browser, 0)
    browser.find_element("id", "play").click()
    texts += browser.execute_script(TEXTS)
    browser.find_element("id", "play").click()
    assert browser.get_log("browser") == []
    return {text for text in texts if re.search("[a-zà-ü]{3}", text)}


@pytest.mark.parametrize("language", ["it", "pt"])
def test_no_english_phrase_is_left_in_a_report_of_another_language(spoken, browser, language):
    english, told = read_aloud(browser, spoken["en"]), read_aloud(browser, spoken[language])
    assert len(english) > 200
    assert len(told) > 200
    assert english & told - EQUAL == set()


@pytest.mark.parametrize("language", LANGUAGES)
def test_the_names_of_the_curves_stay_inside_their_chart(spoken, browser, language):
    """Long ones ran over its right end, and before that over its left one."""
    opened(browser, spoken[language])
    ends = browser.execute_script(
        "const box = (e) => e.getBBox(); const frame = box(document.querySelector('#chart path'));"
        "const names = [...document.querySelectorAll('#chart text')].filter((t) => t.textContent.length > 20).map(box);"
        "return names.map((b) => [b.x - frame.x, frame.x + frame.width - b.x - b.width])"
    )
    inside = [end for end in ends if end[0] > 0.0]
    assert len(inside) >= 2
    assert min(right for _, right in inside) > -1.0


def test_rows_of_damage_and_settings_print_on_one_line_in_every_language(spoken, browser):
    """Longer heads of columns must not squeeze what stands below them: it made the Italian PDF two pages longer."""
    rows = "return [...document.querySelectorAll('#damage tbody tr, #input tbody tr')].map((r) => r.offsetHeight)"
    browser.execute_cdp_cmd("Emulation.setEmulatedMedia", {"media": "print"})
    browser.execute_cdp_cmd(
        "Emulation.setDeviceMetricsOverride", {"width": 688, "height": 900, "deviceScaleFactor": 1, "mobile": False}
    )  # 182 mm, A4 without its margins
    try:
        for language, address in spoken.items():
            opened(browser, address)
            assert browser.execute_script("return document.documentElement.lang") == language
            heads = browser.execute_script("return document.querySelectorAll('#damage thead').length")
            assert heads == 2, "one table a model, whose rest a screen shows when asked: a second head was in mid-page"
            heights = sorted(browser.execute_script(rows))
            assert len(heights) > 100
            assert heights[len(heights) * 9 // 10] < 1.5 * heights[len(heights) // 10], language
    finally:
        browser.execute_cdp_cmd("Emulation.setEmulatedMedia", {"media": ""})
        browser.execute_cdp_cmd("Emulation.clearDeviceMetricsOverride", {})


def test_the_rest_of_a_long_table_of_damage_is_shown_when_asked_for(page):
    visible = "return [...document.querySelectorAll('#damage tbody.more tr')].filter((r) => r.offsetHeight).length"
    assert page.execute_script(visible) == 0
    for label in page.find_elements("css selector", "input.more + label"):
        label.click()
    shown = page.execute_script(visible)
    assert shown == len(page.find_elements("css selector", "#damage tbody.more tr")) > 0


def test_a_result_that_is_not_valid_says_so_at_the_top(run, browser, tmp_path):
    shutil.copytree(run, tmp_path / "run")
    file = tmp_path / "run" / "summary.json"
    summary = json.loads(file.read_text(encoding="utf-8"))
    summary["pushover"][1] |= {"equilibrium_residual": 0.02, "complaint": "result not valid: micro equilibrium: 2 %"}
    file.write_text(json.dumps(summary), encoding="utf-8")
    storage.write_summary(file.parent, storage.read_summary(file.parent))  # as a run that failed had written it
    with undrawn():
        assert main(["report", str(tmp_path / "run")]) == 0
    opened(browser, (tmp_path / "run" / "report.html").as_uri())
    said = browser.find_element("id", "verdict").text
    assert "NOT VALID" in said
    assert "micro equilibrium: 2 %" in said
    assert "NOT VALID" in browser.find_element("id", "checks").text


def test_report_rebuilds_the_same_page_and_pictures_from_the_folder_alone(run, tmp_path):
    moved = tmp_path / "elsewhere"
    shutil.copytree(run, moved)
    before = {path.name: path.read_bytes() for path in (moved / "figures").iterdir()}
    shutil.rmtree(moved / "figures")
    page = (moved / "report.html").read_bytes()
    (moved / "report.html").unlink()
    assert main(["report", str(moved)]) == 0
    assert (moved / "report.html").read_bytes() == page
    assert {path.name: path.read_bytes() for path in (moved / "figures").iterdir()} == before


def test_no_page_of_the_pdf_ends_between_a_table_and_what_leads_to_it(page, run):
    """A heading and its sentence stood at the foot of a page, the table on the next one; the reactions were parted."""
    asked = """return [...document.querySelectorAll('section')].flatMap((s) => [...s.querySelectorAll('table')])
        .map((t) => { let above = t.previousElementSibling;
                      while (above && above.matches('input, label')) above = above.previousElementSibling;
                      return above && above.matches('h2, h3, p') ? getComputedStyle(above).breakAfter : 'avoid'; })"""
    page.execute_cdp_cmd("Emulation.setEmulatedMedia", {"media": "print"})
    try:
        opened(page, (run / "report.html").as_uri())
        found = page.execute_script(asked)
        reactions = "return getComputedStyle(document.querySelector('#forces table:last-of-type')).breakInside"
        assert page.execute_script(reactions) == "avoid"
    finally:
        page.execute_cdp_cmd("Emulation.setEmulatedMedia", {"media": ""})
    assert len(found) > 8
    assert set(found) == {"avoid"}
