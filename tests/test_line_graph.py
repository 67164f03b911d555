"""Nodes near segments of a centerline's lines, against all pairs, in bounded memory."""

from __future__ import annotations

import numpy as np
import pytest

from SDFStentLib.centerline import Centerline, line_graph, overlaps
from SDFStentLib.centerline.line_graph import LineGraph, near_pairs
from SDFStentLib.geometry import distances_to_segments


def a_graph(seed=5, count=60):
    rng = np.random.default_rng(seed)
    points = np.cumsum(rng.normal(size=(count, 3)), axis=0)
    edges = np.column_stack([np.arange(count - 1), np.arange(1, count)])
    return LineGraph(points, rng.uniform(0.2, 2.0, count), np.delete(edges, [19, 39], axis=0))


def all_pairs(graph, reach, piece=None):
    """Every node with every segment."""
    found = {}
    for number, (a, b) in enumerate(graph.edges):
        for node, point in enumerate(graph.points):
            squared, _ = distances_to_segments(point[None], graph.points[[a]], graph.points[[b]])
            is_apart = piece is None or piece[node] != piece[a]
            if node not in (a, b) and is_apart and squared[0] <= max(reach[a], reach[b]) ** 2:
                found[node, number] = np.sqrt(squared[0])
    return found


@pytest.mark.parametrize("block", [1, 40, 1 << 18])
@pytest.mark.parametrize("is_apart", [False, True])
def test_near_pairs_are_all_that_are_near_whatever_the_block(monkeypatch, block, is_apart):
    monkeypatch.setattr(line_graph, "PAIRS", block)
    graph = a_graph()
    piece = graph.component_labels() if is_apart else None
    expected = all_pairs(graph, graph.radius, piece)
    pairs = near_pairs(graph, graph.radius, piece)
    found = dict(
        zip(zip(pairs.nodes.tolist(), pairs.segments.tolist(), strict=True), pairs.distances,
            strict=True)
    )  # fmt: skip
    assert found.keys() == expected.keys()
    assert len(found) == len(pairs.nodes) > 0
    for key, distance in expected.items():
        assert found[key] == pytest.approx(distance, abs=1e-12)


def lines_beside_each_other(count, outlets, seed=0):
    """Lines from one inlet to several outlets, each with points of its own, 0.03 mm apart."""
    random = np.random.default_rng(seed)
    points, lines = [], []
    for number in range(count):
        along = np.sort(np.r_[0.0, random.uniform(0.0, 40.0, 98), 40.0])
        aside = 0.4 * (number % outlets) * np.maximum(along - 15.0, 0.0)
        line = np.column_stack([aside, 0 * along, along]) + random.normal(size=(100, 3)) * 0.01
        lines.append(100 * number + np.arange(100))
        points.append(line)
    return np.concatenate(points), lines, np.full(100 * count, 3.0)


@pytest.mark.parametrize("outlets", [1, 4])
def test_lines_that_share_no_point_become_one_tree_however_many_are_looked_at_together(
    outlets, monkeypatch
):
    made = lines_beside_each_other(24, outlets)
    trees = []
    for pairs in (1 << 40, 1 << 12, 1):
        monkeypatch.setattr(overlaps, "MOST_PAIRS", pairs)
        trees.append(Centerline.from_lines(*made))
    assert len(trees[0].leaves) == outlets
    for tree in trees[1:]:
        np.testing.assert_array_equal(tree.points, trees[0].points)
        np.testing.assert_array_equal(tree.parent, trees[0].parent)
