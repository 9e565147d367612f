"""Stones on a layer that was not chosen are told, and what is drawn over, round or away from them is not; and other
files that were read wrong or refused in words of the program's own."""

from __future__ import annotations

import ezdxf
import numpy as np
import pytest
from skimage.io import imsave

from orchestrator.app.intake import import_wall
from orchestrator.basis.errors import CaseError
from orchestrator.masonry.sources.closed_outlines import is_chosen
from tests.support.drawings import MILLIMETRES
from tests.support.walls import between

GROUND, MATERIAL = between(-100, -200, 1700, 0), {"thickness": "0.5 m"}
STONES = [between(400 * c, 0, 400 * c + 400, 200) for c in range(4)]
BESIDE = {
    "a course above": [between(400 * c, 200, 400 * c + 400, 400) for c in range(4)],
    "a frame": [between(-500, -500, 2500, 2500)],
    "a hatch over a stone": [between(10, 10, 390, 190)],
    "a legend": [between(5000, 0, 5400, 200)],
}


def told(remarks):
    return [remark for remark in remarks if "which is not chosen" in remark]


@pytest.mark.parametrize("what", BESIDE)
def test_what_lies_beside_the_stones_on_another_layer_of_a_drawing_is_told(tmp_path, what):
    document = ezdxf.new()
    document.header["$INSUNITS"] = MILLIMETRES
    for outlines, layer in ((STONES, "blocks"), ([GROUND], "supports"), (BESIDE[what], "Blocks2")):
        for outline in outlines:
            document.modelspace().add_lwpolyline(outline, close=True, dxfattribs={"layer": layer})
    document.saveas(tmp_path / "wall.dxf")
    found = told(import_wall(tmp_path / "wall.dxf", MATERIAL).remarks)
    said = "4 closed outlines beside the stones left out, on 'Blocks2', which is not chosen: if stones, add "
    assert found == [f'{said}--blocks "blocks,Blocks2"'] * (what == "a course above")
    whole = import_wall(tmp_path / "wall.dxf", MATERIAL | {"blocks": "blocks,Blocks2"}) if found else None
    assert whole is None or len(whole.wall.blocks) == 9


def test_a_group_that_was_not_chosen_is_told(tmp_path):
    def group(name, outlines):
        paths = "".join(f'<path d="M{" L".join(f"{x} {-y}" for x, y in outline)} Z"/>' for outline in outlines)
        return f'<g id="{name}">{paths}</g>'

    groups = group("blocks", STONES) + group("supports", [GROUND]) + group("timber", BESIDE["a course above"])
    size = 'width="1800mm" height="900mm" viewBox="-100 -700 1800 900"'
    (tmp_path / "wall.svg").write_text(f'<svg xmlns="http://www.w3.org/2000/svg" {size}>{groups}</svg>')
    assert len(told(import_wall(tmp_path / "wall.svg", MATERIAL).remarks)) == 1


def test_a_block_file_may_begin_with_a_byte_order_mark(tmp_path):
    """`import` read it twice, the second time with a traceback."""
    stones = '{"id": 1, "polygon": [[0, 0], [1, 0], [1, 1], [0, 1]], "fixed": false}'
    ground = '{"id": 0, "polygon": [[0, -1], [1, -1], [1, 0], [0, 0]], "fixed": true}'
    units = '"units": {"length": "m", "unit_weight": "N/m3"}, "thickness": 0.5, "unit_weight": 20e3, "friction": 0.7'
    text = f'{{{units}, "blocks": [{ground}, {stones}]}}'
    (tmp_path / "wall.json").write_text(text, encoding="utf-8-sig")
    assert len(import_wall(tmp_path / "wall.json", {}).wall.blocks) == 2


@pytest.mark.parametrize("scale", ["4 m", "35 mm"])
def test_pixels_too_coarse_for_joints_are_refused_by_the_option_s_name(tmp_path, scale):
    picture = np.zeros((122, 122), dtype=np.uint8)
    picture[::40] = picture[1::40] = picture[:, ::40] = picture[:, 1::40] = 255
    imsave(tmp_path / "wall.png", picture, check_contrast=False)
    with pytest.raises(CaseError, match=r"--scale: a pixel of .* is too coarse for joints; give at most \"33 mm\""):
        import_wall(tmp_path / "wall.png", MATERIAL | {"scale": scale, "ground": "0.2 m"})


def test_brackets_in_the_names_of_layers_stand_for_themselves():
    assert is_chosen("stones [old]", "blocks, stones [old]")
    assert is_chosen("Stones 12", "stones *")
    assert not is_chosen("stones o", "stones [old]")
