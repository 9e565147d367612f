"""Wall 1 of Ferris and Tin-Loi (2001) drawn, painted and written in rows, and how to tell that it came back."""

from __future__ import annotations

import ezdxf
import numpy as np
import shapely
from PIL import Image, ImageDraw

from orchestrator.limit_analysis import analyse
from orchestrator.masonry.joints import JointSettings, find_joints
from orchestrator.masonry.sources.block_files import read_blocks
from orchestrator.masonry.sources.drawing import Material
from tests.support.paths import DATA

WALL_1 = read_blocks(DATA / "ferris_tinloi_wall1.json")
PUBLISHED = 0.643
"""associative multiplier of wall 1, Ferris and Tin-Loi (2001), three digits"""
MATERIAL = Material(thickness=0.1, unit_weight=25e3, friction=0.65)
ROWS = """
unit = mm
thickness = 100
unit_weight = 25 kN/m3
friction = 0.65
support = 200
""" + "\n".join(["175: 200 400 400 400 400 200", "175: 400 400 400 400 400"] * 3)


def associative(wall):
    assemblage = find_joints(wall, JointSettings())
    return analyse(assemblage).associative.load_multiplier


def assert_same_wall(found, expected, within=1e-9):
    """Every block has its twin: same outline, wherever its corners are listed, same part."""
    assert len(found.blocks) == len(expected.blocks)
    assert (found.thickness, found.friction) == (expected.thickness, expected.friction)
    free = [shapely.Polygon(block.polygon) for block in expected.blocks]
    for block in found.blocks:
        outline = shapely.Polygon(block.polygon)
        twin = min(range(len(free)), key=lambda k: free[k].centroid.distance(outline.centroid))
        assert outline.hausdorff_distance(free[twin]) < within, block.id
        assert expected.blocks[twin].fixed == block.fixed
        assert expected.blocks[twin].unit_weight == block.unit_weight


def written(path, draw, insunits=4):
    document = ezdxf.new()
    document.header["$INSUNITS"] = insunits
    draw(document.modelspace(), document)
    document.saveas(path)
    return path


def as_polylines(wall, noise=0.0, factor=1000.0):
    """Return a function that draws each block as a closed polyline, in mm, corners displaced by up to `noise` m."""
    random = np.random.default_rng(1)

    def draw(space, _):
        for block in wall.blocks:
            corners = block.polygon + random.uniform(-noise, noise, block.polygon.shape)
            layer = {"layer": "Supports" if block.fixed else "BLOCKS"}
            space.add_lwpolyline(factor * corners, close=True, dxfattribs=layer)

    return draw


def painted(path, wall, scale, mortar, background="white", stone="black"):
    """Paint the free blocks, each smaller by half the mortar on every side, `scale` m a pixel."""
    free = [block for block in wall.blocks if not block.fixed]
    low, high = (f(np.vstack([b.polygon for b in free]), axis=0) for f in (np.min, np.max))
    width, height = np.round((high - low) / scale).astype(int) + 40
    image = Image.new("RGB", (int(width), int(height)), background)
    for block in free:
        inset = shapely.get_coordinates(shapely.Polygon(block.polygon).buffer(-mortar / 2, join_style="mitre"))
        (left, bottom), (right, top) = (f(inset, axis=0) for f in (np.min, np.max))
        corners = (left - low[0], high[1] - top, right - low[0], high[1] - bottom)
        x0, y0, x1, y1 = (round(c / scale) + 20 for c in corners)
        ImageDraw.Draw(image).rectangle([x0, y0, x1 - 1, y1 - 1], fill=stone)
    image.save(path)
    return path


def areas(wall):
    return np.sort([shapely.Polygon(block.polygon).area for block in wall.blocks if not block.fixed])


def joint_lengths(wall):
    assemblage = find_joints(wall, JointSettings())
    return assemblage.joints.count, float(assemblage.joints.length.sum())


def touching_pairs(wall, longer_than=0.0):
    assemblage = find_joints(wall, JointSettings())
    long = assemblage.joints.length > longer_than
    return len(set(zip(assemblage.joints.i[long].tolist(), assemblage.joints.j[long].tolist(), strict=True)))


def rubble(seed, count=40):
    """Return the outlines of `count` stones without courses that fill 2 m x 1.5 m: a centred Voronoi diagram."""
    random, frame = np.random.default_rng(seed), shapely.box(0, 0, 2, 1.5)
    points = random.uniform([0, 0], [2, 1.5], (count, 2))
    for _ in range(3):
        cells = shapely.get_parts(shapely.voronoi_polygons(shapely.MultiPoint(points), extend_to=frame))
        cells = shapely.intersection(cells, frame)
        points = shapely.get_coordinates(shapely.centroid(cells))
    return [shapely.get_coordinates(cell.exterior)[:-1] for cell in cells]
