"""One planar map of a wall: every point of it belongs to one block or to none, whatever the errors of its outlines."""

from __future__ import annotations

from itertools import pairwise

import numpy as np
import pytest
import shapely

from orchestrator.geometry.healing import heal, open_gaps
from orchestrator.geometry.planar_map import NO_BLOCK, OverlapError, planar_map
from orchestrator.masonry.patterns import (
    ArchedOpening,
    ArchedWall,
    IrregularCourses,
    Rubble,
    arched_wall,
    rubble,
    running_bond,
)
from orchestrator.masonry.sources.drawing import Drawing, HealingSettings, Material, wall_of
from tests.support.drawings import with_errors
from tests.support.walls import rectangle

ARCHED = ArchedWall(
    IrregularCourses(3.2, 2.8, thickness=0.4, widths=(0.3, 0.5), heights=(0.2, 0.28), overlap=0.06),
    (ArchedOpening(1.1, 2.1, 0.0, 1.2, depth=0.25, voussoirs=11),),
)
WALLS = {
    "bond": lambda seed: running_bond(4 + seed % 3, 5),
    "rubble": lambda seed: rubble(Rubble(2.0, 1.6, stone=0.3, seed=seed)),
    "arch": lambda seed: arched_wall(ArchedWall(IrregularCourses(**courses(seed)), ARCHED.arches)),
}


def courses(seed):
    names = ("length", "height", "thickness", "widths", "heights", "overlap")
    return {name: getattr(ARCHED.courses, name) for name in names} | {"seed": seed}


def joints(made):
    """Return the pairs of blocks that share an edge, with the number of edges."""
    pairs, count = np.unique(np.column_stack([made.left, made.right]), axis=0, return_counts=True)
    return {(int(i), int(j)): int(n) for (i, j), n in zip(pairs, count, strict=True) if j != NO_BLOCK}


def touching(outlines):
    """Return the pairs of exact outlines that share a length, found by shapely alone."""
    shapes = [shapely.Polygon(outline) for outline in outlines]
    near = shapely.STRtree(shapes).query(shapes, predicate="dwithin", distance=1e-9)
    return {
        (int(i), int(j))
        for i, j in near.T
        if i < j and shapes[i].boundary.intersection(shapes[j].buffer(1e-7)).length > 1e-5
    }


def assert_planar(made, outlines, tolerance):
    """Rings are simple, share no area, and lie where outlines were drawn; every edge is on the rings of its blocks."""
    rings = [shapely.Polygon(made.vertex[made.ring(block)]) for block in range(len(outlines))]
    assert all(ring.is_valid for ring in rings)
    area = sum(ring.area for ring in rings)
    assert shapely.union_all(rings).area == pytest.approx(area, rel=1e-9)
    for ring, outline in zip(rings, outlines, strict=True):
        assert ring.hausdorff_distance(shapely.Polygon(outline)) < 6 * tolerance + 1e-9
    directed = np.concatenate(
        [np.column_stack([made.ring(b), np.roll(made.ring(b), -1)]) for b in range(len(outlines))]
    )
    inner = made.right != NO_BLOCK
    edges = np.concatenate([np.column_stack([made.start, made.end]), np.column_stack([made.end, made.start])[inner]])
    assert sorted(map(tuple, directed.tolist())) == sorted(map(tuple, edges.tolist()))


@pytest.mark.parametrize("seed", range(4))
@pytest.mark.parametrize("family", WALLS)
@pytest.mark.parametrize(("errors", "tolerance"), [({}, 1e-5), ({"error": 4e-4}, 1.5e-3), ({"rounding": 1e-3}, 2e-3)])
def test_a_wall_with_errors_has_the_joints_of_the_exact_one(family, seed, errors, tolerance):
    wall = WALLS[family](seed)
    exact = planar_map([block.polygon for block in wall.blocks], 1e-6)
    outlines = with_errors(wall, **errors, seed=seed) if errors else [block.polygon for block in wall.blocks]
    made = planar_map(outlines, tolerance)
    assert set(joints(exact)) == touching([block.polygon for block in wall.blocks])
    assert joints(made) == joints(exact)
    assert_planar(made, outlines, tolerance)


@pytest.mark.parametrize("family", WALLS)
def test_a_larger_tolerance_joins_what_a_smaller_one_joined_in_the_same_way(family):
    wall = WALLS[family](1)
    outlines = with_errors(wall, error=4e-4, seed=1)
    maps = [planar_map(outlines, tolerance) for tolerance in (1.2e-3, 2e-3, 5e-3, 1e-2, 2e-2)]
    for made in maps[1:]:
        np.testing.assert_array_equal(made.vertex, maps[0].vertex)
        np.testing.assert_array_equal(made.start, maps[0].start)
        np.testing.assert_array_equal(made.left, maps[0].left)


def test_nothing_moves_where_outlines_touch_already():
    wall = rubble(Rubble(2.0, 1.6, stone=0.3, seed=3))
    made = planar_map([block.polygon for block in wall.blocks], 5e-3)
    corners = {tuple(corner) for block in wall.blocks for corner in block.polygon.tolist()}
    assert {tuple(vertex) for vertex in made.vertex.tolist()} <= corners
    assert made.error == 0.0
    assert not made.width.any()


@pytest.mark.parametrize(("family", "gap"), [(f, g) for f in WALLS for g in (3e-3, 1e-2)] + [("bond", 2e-2)])
def test_gaps_of_mortar_close_to_their_middle(family, gap):
    """Outlines set back by half a gap all round must come back where the exact ones are, but for the outer faces."""
    wall = WALLS[family](2)
    exact = planar_map([block.polygon for block in wall.blocks], 1e-6)
    made = planar_map(with_errors(wall, gap=gap), 1.5 * gap, short=0.01)
    assert joints(made) == joints(exact)
    inner = made.right != NO_BLOCK
    assert np.median(made.width[inner]) == pytest.approx(gap, rel=1e-9)
    assert made.width[inner] == pytest.approx(gap, rel=0.35)  # less where a corner takes its tip off
    outer = shapely.union_all([shapely.Polygon(block.polygon) for block in wall.blocks]).boundary
    known = shapely.MultiPoint(exact.vertex)
    for edge in np.flatnonzero(inner):
        for vertex in made.vertex[[made.start[edge], made.end[edge]]]:
            if outer.distance(shapely.Point(vertex)) > 2 * gap:
                assert known.distance(shapely.Point(vertex)) < 0.05 * gap


def keyed_course(splay, depth=0.08, widths=(0.7, 0.75, 0.8, 0.6), height=0.5):
    """Stones whose head joints are dovetails: a key is wider by `splay` at either side of its end than at its root."""
    at = np.concatenate([[0.0], np.cumsum(widths)])

    def key(x):
        low, high = 0.35 * height, 0.65 * height
        return [[x, low], [x + depth, low - splay], [x + depth, high + splay], [x, high]]

    return [
        np.array([[a, 0.0], [b, 0.0], *(key(b) if k < len(widths) - 1 else []), [b, height], [a, height],
                  *(key(a)[::-1] if k else [])])
        for k, (a, b) in enumerate(pairwise(at.tolist()))
    ]  # fmt: skip


@pytest.mark.parametrize("splay", [-0.05, 0.0, 0.03, 0.05, 0.08])
@pytest.mark.parametrize(("gap", "mortar"), [(5e-3, 5e-3), (5e-3, 6e-3), (5e-3, 8e-3), (2e-3, 1e-2)])
def test_dovetails_drawn_with_mortar_between_them_have_the_joints_of_the_exact_ones(splay, gap, mortar):
    """Across the corner of a joint the corners lie 1.4 to 3.8 gaps apart, at 90 and 31 degrees: five joints of a key,
    none open, each line where it is without mortar."""
    exact = [rectangle(-0.3, -0.2, 3.5, 0.2), *keyed_course(splay)]
    back = [shapely.Polygon(outline).buffer(-0.5 * gap, join_style="mitre", mitre_limit=20) for outline in exact]
    drawn = [shapely.get_coordinates(shapely.geometry.polygon.orient(one))[:-1] for one in back]
    healed, made = heal(drawn, 1.5 * mortar)
    assert joints(made) == joints(planar_map(exact, 1e-6))
    assert not open_gaps(made)
    outer = shapely.union_all([shapely.Polygon(outline) for outline in exact]).boundary.buffer(2 * gap)
    for one, other in zip(healed[1:], exact[1:], strict=True):
        corners = shapely.MultiPoint(other)
        inner = [point for point in shapely.points(one) if not outer.contains(point)]
        assert max(map(corners.distance, inner), default=0.0) < 0.05 * gap


def test_the_map_does_not_depend_on_the_order_and_turn_of_the_wall():
    wall = arched_wall(ARCHED)
    outlines = with_errors(wall, error=4e-4, seed=5)
    made = planar_map(outlines, 2e-3)
    order = np.random.default_rng(0).permutation(len(outlines))
    other = planar_map([outlines[k] for k in order], 2e-3)
    back = {tuple(sorted((int(order[i]), int(order[j])))): n for (i, j), n in joints(other).items()}
    assert back == joints(made)
    turn = np.array([[np.cos(0.6), -np.sin(0.6)], [np.sin(0.6), np.cos(0.6)]])
    turned = planar_map([3.0 * outline @ turn.T + [70.0, -20.0] for outline in outlines], 6e-3)
    assert joints(turned) == joints(made)
    for block in range(len(outlines)):
        ring, image = made.vertex[made.ring(block)], turned.vertex[turned.ring(block)]
        assert image == pytest.approx(3.0 * ring @ turn.T + [70.0, -20.0], abs=3e-6)


def test_a_thin_block_between_two_is_not_squeezed_out():
    """A sheet of 4 mm between two blocks, all 1 mm apart, at a tolerance far above its thickness."""
    outlines = [rectangle(0, 0, 1, 0.3), rectangle(0, 0.301, 1, 0.004), rectangle(0, 0.306, 1, 0.3)]
    made = planar_map(outlines, 2e-2)
    assert joints(made) == {(0, 1): 1, (1, 2): 1}
    assert shapely.Polygon(made.vertex[made.ring(1)]).area == pytest.approx(0.005, rel=1e-6)


def test_chains_between_two_blocks_stay_polylines_or_become_straight():
    bow = [[1.0, 0.3], [0.5, 0.32], [0.0, 0.3]]
    lower = np.array([[0, 0], [1, 0], *bow])
    upper = np.array([*bow[::-1], [1.0, 0.6], [0.0, 0.6]])
    assert joints(planar_map([lower, upper], 1e-5)) == {(0, 1): 2}
    assert joints(planar_map([lower, upper], 1e-5, bend=1 / 30)) == {(0, 1): 1}


def test_blocks_on_one_another_are_refused_with_their_place():
    with pytest.raises(OverlapError) as caught:
        planar_map([rectangle(0, 0, 1, 1), rectangle(0, 0, 1, 2)], 1e-3)
    assert caught.value.blocks == (0, 1)


@pytest.mark.parametrize("turn", [0.0, 0.3])
@pytest.mark.parametrize("scale", [0.1, 1.0, 10.0])
@pytest.mark.parametrize(("bed", "head"), [(0.0, 3e-3), (0.0, 1e-4), (5e-4, 5e-3), (1e-4, 1e-4), (2.5e-3, 5e-3)])
def test_head_joints_over_tight_beds_close(bed, head, scale, turn):
    """Both corners of a head gap enter the edge below before they meet each other."""
    outlines = [rectangle(-0.2, -0.3, 2.0, 0.3)]
    for course in range(4):
        left = 0.2 * (course % 2)
        ends = np.concatenate([[0.0], np.arange(left + 0.4, 1.6 + 1e-9, 0.4), [1.6] if course % 2 else []])
        bottom = course * 0.2 + bed
        for a, b in pairwise(ends.tolist()):
            outlines.append(rectangle(a + head * (a > 0), bottom, b - a - head * (a > 0), 0.2 - bed))
    exact = touching([np.round(outline, 1) for outline in outlines])
    rotation = np.array([[np.cos(turn), -np.sin(turn)], [np.sin(turn), np.cos(turn)]])
    made = planar_map([scale * outline @ rotation.T for outline in outlines], scale * 1.5 * max(bed, head))
    assert set(joints(made)) == exact


def test_a_gap_as_wide_as_the_tolerance_is_closed():
    made = planar_map([rectangle(0, 0, 1, 0.3), rectangle(0, 0.301, 1, 0.3)], 1e-3)
    assert joints(made) == {(0, 1): 1}


def test_a_stone_in_a_pocket_keeps_its_shape_where_bends_become_straight():
    pocket = np.array(
        [[0, 0.2], [0.05, 0.2], [0.05, 0.215], [0.45, 0.215], [0.45, 0.2], [0.5, 0.2], [0.5, 0.5], [0, 0.5]]
    )
    outlines = [rectangle(0, 0, 0.5, 0.2), rectangle(0.05, 0.2, 0.4, 0.015), pocket]
    made = planar_map(outlines, 1e-3, bend=1 / 20)
    assert_planar(made, outlines, 1e-3)


def bowed(*points):
    """Two blocks of 1 m on a bed through the points, from left to right."""
    bow = np.array(points)
    return np.vstack([[[0, 0], [1, 0]], bow[::-1]]), np.vstack([bow, [[1.0, 1.0], [0.0, 1.0]]])


def test_a_bent_joint_of_two_blocks_is_judged_once():
    """Seen from either block, ties would keep one corner each, and neither would stay."""
    blocks = bowed([0.0, 0.5], [0.3, 0.555], [0.301, 0.5558], [0.699, 0.5558], [0.7, 0.555], [1.0, 0.5])
    made = planar_map(blocks, 1e-3, bend=1 / 20)
    assert joints(made) == {(0, 1): 3}
    assert 0 < made.straightened < 1e-3
    assert_planar(made, blocks, 1e-3)


def test_an_arc_becomes_straight_and_a_hump_on_a_long_bed_does_not():
    angle = np.linspace(-0.19, 0.19, 30)
    arc = np.column_stack([0.5 + np.sin(angle) / np.sin(0.19) / 2, 0.5 + (np.cos(angle) - np.cos(0.19)) / 0.4])
    hump = [[0.0, 0.5], [0.4, 0.5], [0.45, 0.54], [0.55, 0.54], [0.6, 0.5], [1.0, 0.5]]
    assert joints(planar_map(bowed(*arc), 1e-4, bend=1 / 20)) == {(0, 1): 1}
    assert joints(planar_map(bowed(*hump), 1e-4, bend=1 / 20)) == {(0, 1): 5}


def test_a_joint_that_bends_more_than_an_arc_that_is_taken_straight_becomes_chords_within_the_tolerance():
    """Chords that bent by 1/20 themselves would be two here, hooked by 23 degrees."""
    angle = np.linspace(-0.5, 0.5, 200)
    bow = np.column_stack([0.5 + np.sin(angle) / np.sin(0.5) / 2, 0.5 + np.cos(angle) - np.cos(0.5)])
    blocks = bowed(*bow)
    made = planar_map(blocks, 1e-3, bend=1 / 20, short=0.01)
    assert made.straightened < 1e-3
    assert 8 < joints(made)[0, 1] < 30
    assert_planar(made, blocks, 1e-3)


@pytest.mark.parametrize("tolerance", [1e-5, 1e-3, 5e-3])
@pytest.mark.parametrize("spacing", [1e-3, 4e-3, 9e-3])
def test_corners_drawn_close_to_each_other_along_straight_beds_change_nothing(tolerance, spacing):
    """Each edge is shorter than 1/100 of a stone: one taken for a point after the other would eat the wall up."""
    stones = [rectangle(0.9 * k + 0.45 * (course % 2), 0.45 * course, 0.9, 0.45) for course in (0, 1) for k in range(3)]
    stones.append(rectangle(-1.0, -0.5, 5.0, 0.5))
    healed, made = heal(
        [shapely.get_coordinates(shapely.segmentize(shapely.Polygon(one), spacing))[:-1] for one in stones], tolerance
    )
    for drawn, one in zip(stones, healed, strict=True):
        assert shapely.Polygon(drawn).symmetric_difference(shapely.Polygon(one)).area < 1e-9
    assert set(joints(made)) == touching(stones)


@pytest.mark.parametrize(("spacing", "most"), [(2e-3, 70), (6e-3, 70), (15e-3, 159)])
def test_wavy_beds_stay_where_they_were_drawn_however_finely(spacing, most):
    x = np.linspace(0.0, 2.4, int(2.4 / spacing))
    bed = np.column_stack([x, 0.5 + 0.04 * np.sin(2 * np.pi * x / 0.6)])
    lower = np.vstack([[[0.0, 0.0], [2.4, 0.0]], bed[::-1]])
    upper = np.vstack([bed, [[2.4, 1.0], [0.0, 1.0]]])
    healed, made = heal([lower, upper], 1e-3)
    for drawn, one in zip((lower, upper), healed, strict=True):
        assert shapely.hausdorff_distance(shapely.Polygon(drawn), shapely.Polygon(one)) < 1.5e-3
    assert joints(made)[0, 1] <= most


def test_a_vertex_where_lines_are_nearly_parallel_does_not_pass_the_next_one():
    """Wall 68 of docs/studies/any_wall.py, errors of 3 mm: a springer (1) between voussoirs, under a bed that it bends
    by half a degree; the corner of the course above went 9 mm along that bed, past the springer's own."""
    outlines = [
        [(0.3212, 0.3008), (0.4970, 0.3940), (0.6996, 0.4459), (0.4819, 0.4443), (0.1860, 0.1857)],
        [(0.8746, 0.1943), (0.8994, 0.4439), (0.8590, 0.4450), (0.6980, 0.4445), (0.7258, 0.1982)],
        [(0.8577, 0.4459), (0.8561, 0.7029), (0.6853, 0.7053), (0.4783, 0.7058), (0.4821, 0.4462), (0.7004, 0.4410)],
        [(0.7271, 0.1940), (0.6970, 0.4436), (0.4981, 0.3936), (0.5868, 0.1604)],
    ]
    made = planar_map([np.array(outline) for outline in outlines], 9e-3, short=0.01)
    assert all(shapely.Polygon(made.vertex[made.ring(block)]).is_valid for block in range(4))


ACUTE = [
    [(0.0275, -0.2515), (-0.0019, 0.0001), (-0.2021, -0.0466), (-0.1126, -0.2841)],
    [(0.1752, -0.2507), (0.2044, -0.0021), (0.0975, -0.0026), (0.0005, -0.0011), (0.0289, -0.2488)],
    [(-0.3821, -0.1439), (-0.1988, -0.0523), (-0.0012, -0.0028), (-0.4125, 0.0003), (-0.7121, -0.0002),
     (-0.7113, -0.2152), (-0.4606, -0.2128)],
    [(0.0982, -0.0039), (0.0968, 0.2677), (-0.1352, 0.2665), (-0.4147, 0.266), (-0.4119, 0.0), (-0.0047, -0.0014)],
]  # fmt: skip
"""Two voussoirs, the acute stone beside them and the one above, drawn with errors of 3 mm: the tip overlaps."""


def test_acute_tips_that_are_cut_back_and_short_edges_are_counted():
    outlines = [np.array(outline) for outline in ACUTE]
    made = planar_map(outlines, 9e-3, short=0.01)
    assert_planar(made, outlines, 9e-3)
    assert made.tips == (pytest.approx(0.01024, rel=1e-3),)
    assert made.collapsed
    assert max(made.collapsed) <= max(made.error, 0.01)
    exact = planar_map([rectangle(0, 0, 1, 1), rectangle(1, 0, 1, 1)], 9e-3, short=0.01)
    assert (exact.tips, exact.collapsed) == ((), ())


@pytest.mark.parametrize(("angle", "joined"), [(15, True), (25, True), (40, False), (90, False)])
def test_a_tip_is_cut_back_as_far_as_the_tolerance_moves_it_and_a_right_angle_is_none(angle, joined):
    """Two stones on a bed beside each other, whose joint rises at an angle: one overlaps the other by 2 mm along the
    bed, which is as deep as the tolerance at 30 degrees."""
    rise = np.array([0.4 / np.tan(np.radians(angle)), 0.4]) if angle < 90 else np.array([0.0, 0.4])
    foot, over = np.array([1.0, 0.0]), np.array([2e-3, 0.0])
    left = np.array([(0.0, 0.0), foot + over, foot + over + rise, (0.0, 0.4)])
    right = np.array([foot, (4.0, 0.0), (4.0, 0.4), foot + rise])
    outlines = [rectangle(0, -0.4, 4.0, 0.4), left, right]
    tolerance = 2e-3 * np.sin(np.radians(30))
    if joined:
        assert len(planar_map(outlines, tolerance, short=0.01).tips) == 2
    else:
        with pytest.raises(OverlapError):
            planar_map(outlines, tolerance, short=0.01)


def test_what_was_cut_back_and_taken_for_points_is_said():
    outlines = [np.array(outline) for outline in ACUTE]
    ground = rectangle(-0.8, -0.6, 1.2, 0.2)
    drawing = Drawing(tuple(outlines), (ground,))
    _, said = wall_of(drawing, "tips", Material(0.3), HealingSettings(9e-3))
    assert "WARNING: 1 acute tip that overlaps cut back by up to 10 mm, more than the tolerance" in said
    assert any(remark.startswith(("1 short edge", "2 short edges", "3 short edges")) for remark in said)
