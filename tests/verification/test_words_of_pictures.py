"""The words inside pictures: every picture of one case in Italian and Portuguese, without a word of English.

The pictures are those of a portal with all that they can show: materials, bonded joints, a floor, a tie, a support that
gives way, curves of both models, a verification, two load cases. What stands in them is taken from the figures as they
are saved, and compared with what stands in the English ones: no word may be the same unless it comes from the input or
is listed below as one of both languages.
"""

from __future__ import annotations

import json
import re
import shutil

import numpy as np
import pytest
from matplotlib.backends.backend_svg import FigureCanvasSVG
from matplotlib.text import Text

from orchestrator.app import driver, load_cases
from orchestrator.app.cli import main
from orchestrator.masonry.sources.block_files import read_blocks
from orchestrator.present import plots
from orchestrator.present.plots.canvas import DOTS_PER_INCH, QUICK, lay_out
from orchestrator.settings import case as cases
from tests.support.paths import DATA
from tests.support.undrawn import undrawn

GROUND = [[[x, -0.5], [x + 2.3, -0.5], [x + 2.3, 0], [x, 0]] for x in (-1, 1.3)]
STONES = [[[x, y], [x + 0.6, y], [x + 0.6, y + 0.75], [x, y + 0.75]] for x in (0, 2) for y in (0, 0.75)]
LINTEL = [[0, 1.5], [2.6, 1.5], [2.6, 1.9], [0, 1.9]]
CASE = """
name = "Porta Qux"
[wall]
blocks = "portal.json"
[[joints.classes]]
between = ["zzbrick", "zzbrick"]
cohesion = "5 kPa"
tensile_strength = "4 kPa"
[[load.dead]]
line_load = "6.5 kN/m"
level = "1.9 m"
inertia = true
[[load.cases]]
name = "zzright"
[[load.cases]]
name = "zzleft"
direction = "-x"
distribution = "mass_height"
{more}[stepping]
final_displacement = "2 mm"
[run]
models = ["macro", "micro"]
[project]
language = "{language}"
"""
VERIFIED = """[seismic]
peak_ground_acceleration = "1.5 m/s2"
"""
TIED = """[[reinforcement.ties]]
blocks = [2, 4]
start = ["0.3 m", "1.4 m"]
end = ["2.3 m", "1.4 m"]
strength = "1.5 kN"
stiffness = "5 kN/mm"
"""
OF_BOTH = {
    "it": {"macro", "micro", "pushover", "base"},
    "pt": {"macro", "micro", "pushover", "interface", "bilinear"},
}
"""words that both languages have"""


@pytest.fixture(scope="module")
def saved(tmp_path_factory):
    """Texts and their boxes (in parts of the figure) of every saved figure of the case: language -> name -> both."""
    folder, found = tmp_path_factory.mktemp("portal"), {}
    blocks = [{"id": n, "polygon": p, "fixed": True} for n, p in enumerate(GROUND, 6)]
    blocks += [{"id": n, "polygon": p, "material": "zzbrick"} for n, p in enumerate(STONES, 1)]
    blocks.append({"id": 5, "polygon": LINTEL, "material": "zzoak"})
    record = {"units": {"length": "m", "unit_weight": "kN/m3"}, "thickness": 0.5, "friction": 0.6, "unit_weight": 20.0}
    (folder / "portal.json").write_text(json.dumps(record | {"blocks": blocks}), encoding="utf-8")
    for language in ("en", "it", "pt"):
        for name, more in (("", VERIFIED), ("tied_", TIED)):
            text = CASE.format(language=language, more=more)
            (folder / f"{name}{language}.toml").write_text(text, encoding="utf-8")
    with undrawn():
        assert main(["run", str(folder / "en.toml"), "--output", str(folder / "en"), "--quiet"]) == 0
    for language in ("en", "it", "pt"):
        run, texts = folder / language, found.setdefault(language, {})
        if language != "en":
            shutil.copytree(folder / "en", run)
            in_language(run, language)
        with pytest.MonkeyPatch.context() as patch:
            patch.setattr(FigureCanvasSVG, "print_svg", recording(FigureCanvasSVG.print_svg, texts))
            draw_all(folder, run, language)
    return found


def in_language(run, language):
    """Say in a run folder that its language is another one."""
    for path in [*run.rglob("case.toml"), *run.glob("*.json")]:
        text = path.read_text(encoding="utf-8")
        path.write_text(re.sub(r'(language"?\s*[:=]\s*)"en"', rf'\1"{language}"', text), encoding="utf-8")


def draw_all(folder, run, language):
    """Draw every picture of a case: those of the report, of `check`, of a settlement, and stamped ones."""
    path = folder / f"tied_{language}.toml"
    assert main(["report", str(run)]) == 0
    assert main(["check", str(path), "--output", str(run / "check")]) == 0
    case = cases.read(path)
    one = next(iter(load_cases.each(case).values()))
    driver.draw_settlement(one, *driver.settlement(one, 7, -np.pi / 2), -np.pi / 2, run)
    figure = plots.blocks(driver.check(case).wall)
    plots.stamp_not_valid(figure)
    plots.save(figure, run, "stamped", language)


def recording(print_svg, texts):
    """Return a `print_svg` that notes what stands in a figure, and where, as parts of its width and height."""

    def record(canvas, content, **options):
        print_svg(canvas, content, **options)
        figure = canvas.figure
        figure.draw_without_rendering()  # legends lie where they were drawn last, and SVG has other pixels
        shown = [text for text in figure.findobj(Text) if text.get_visible() and text.get_text().strip()]
        boxes = [text.get_window_extent().transformed(figure.transFigure.inverted()) for text in shown]
        texts[len(texts)] = [(text.get_text(), box) for text, box in zip(shown, boxes, strict=True)]

    return record


def words(texts):
    said = "\n".join(text for figure in texts.values() for text, _ in figure)
    return {word.lower() for word in re.findall(r"[^\W\d_]{3,}", said)}


@pytest.mark.parametrize("language", ["it", "pt"])
def test_no_word_of_english_is_left_in_a_picture(saved, language):
    english, told = words(saved["en"]), words(saved[language])
    of_input = {"porta", "qux", "zzbrick", "zzoak", "zzright", "zzleft", "mpa"}
    assert len(saved[language]) == len(saved["en"]) > 20
    assert len(english - of_input) > 60
    assert of_input <= english & told, "names of the input stay as they are"
    assert (english & told) - of_input == OF_BOTH[language]


@pytest.mark.parametrize("language", ["it", "pt"])
def test_numbers_in_a_picture_have_decimal_commas(saved, language):
    said = [text for figure in saved[language].values() for text, _ in figure]
    assert not [text for text in said if re.search(r"\d\.\d", text)]
    assert sum(bool(re.search(r"\d,\d", text)) for text in said) > 100
    assert not [text for figure in saved["en"].values() for text, _ in figure if re.search(r"\d,\d", text)]


@pytest.mark.parametrize("language", ["en", "it", "pt"])
def test_no_text_leaves_its_picture(saved, language):
    out = [
        text
        for figure in saved[language].values()
        for text, box in figure
        if re.search(r"[^\W\d_]", text)  # beyond the ends of an axis stand numbers that are not shown
        and (min(box.x0, box.y0) < -1e-3 or max(box.x1, box.y1) > 1.001)
    ]
    assert out == []


def picture():
    wall = read_blocks(DATA / "ferris_tinloi_wall1.json")
    return plots.blocks(wall, numbered=True)


def test_english_pictures_are_as_they_are_drawn(tmp_path):
    """To the byte: that of a figure that was only laid out and written."""
    figure = picture()
    lay_out(figure)
    figure.set_layout_engine("none")
    packed = {"compress_level": QUICK}
    figure.savefig(tmp_path / "drawn.png", dpi=DOTS_PER_INCH, metadata={"Software": None}, pil_kwargs=packed)
    told = {language: plots.save(picture(), tmp_path, language, language)[0] for language in ("en", "it", "pt")}
    assert told["en"].read_bytes() == (tmp_path / "drawn.png").read_bytes()
    assert len({path.read_bytes() for path in told.values()}) == 3
