"""The published method in its plainest form, straight from the paper: the engine must give the
same.

Source: SDFStent, arXiv 2605.22009, section 2. Names of the paper's quantities are in the comments.
Nothing in here is skipped, culled, windowed or stored between steps, and nothing is imported from
the library.
"""

from itertools import pairwise
from typing import NamedTuple

import numpy as np

BLOCK = 2_000_000
"""Distances that are held at once."""


class PlainField(NamedTuple):
    """phi at radius 0 (n,) and its gradient (n, 3)."""

    distance: np.ndarray
    gradient: np.ndarray


def capsule_distance(points, a, b):
    """Distance to the segment from a to b, and its gradient (zero on the segment)."""
    along = b - a
    h = np.clip((points - a) @ along / (along @ along), 0, 1)
    offset = points - (a + h[:, None] * along)
    distance = np.linalg.norm(offset, axis=1)
    gradient = np.zeros_like(offset)
    np.divide(offset, distance[:, None], out=gradient, where=distance[:, None] > 0)
    return distance, gradient


def kernel(x):
    """The function g in the paper's second form of the smooth minimum."""
    return np.where(x < -1, 0, np.where(x > 1, x, (x * (x + 2) + 1) / 4))


def kernel_slope(x):
    """The derivative g' of the kernel."""
    return np.where(x < -1, 0, np.where(x > 1, 1, (x + 1) / 2))


def smin(first, second, k):
    """Smooth minimum of two plain fields: `beta - k g((beta - alpha) / k)` and the chain rule."""
    (alpha, alpha_gradient), (beta, beta_gradient) = first, second
    if k == 0:
        nearer = (beta < alpha)[:, None]
        return PlainField(np.minimum(alpha, beta), np.where(nearer, beta_gradient, alpha_gradient))
    x = (beta - alpha) / k
    slope = kernel_slope(x)[:, None]
    return PlainField(beta - k * kernel(x), slope * alpha_gradient + (1 - slope) * beta_gradient)


def field(points, nodes, k):
    """The field, composed segment by segment from the distal to the proximal end; `nodes` run from
    proximal to distal."""
    nodes = nodes[::-1]
    result = PlainField(*capsule_distance(points, nodes[0], nodes[1]))
    for a, b in pairwise(nodes[1:]):
        result = smin(result, PlainField(*capsule_distance(points, a, b)), k)
    return result


def fall_off(d, influence):
    return np.where(d <= influence, (1 - (np.maximum(d, 0) / influence) ** 2) ** 2, 0)


def nearest_distance(points, targets):
    """The distance of every point to the nearest target, by brute force."""
    from scipy.spatial.distance import cdist

    rows = max(1, BLOCK // max(len(targets), 1))
    parts = [
        cdist(points[start : start + rows], targets).min(axis=1)
        for start in range(0, len(points), rows)
    ]
    return np.concatenate(parts) if parts else np.empty(0)


def step(
    vertices, nodes, radius, growth, *, k=0.4, influence=6.5, contact_threshold=0.01, wall=None
):
    """One pass of the loop in algorithm 1: contact set, influence set, displacement, taper."""
    distance, gradient = field(vertices, nodes, k)
    phi = distance - radius
    contact = phi < contact_threshold
    contact[len(vertices) if wall is None else wall :] = False
    moved = vertices.copy()
    if not contact.any():
        return moved
    apart = nearest_distance(vertices, vertices[contact])
    influenced = apart < influence
    length = np.linalg.norm(gradient, axis=1, keepdims=True)
    direction = np.zeros_like(gradient)
    np.divide(gradient, length, out=direction, where=length > 1e-12)
    alpha = 1 - apart / influence
    amount = growth * fall_off(phi, influence) * alpha
    amount += np.where(phi < 0, -phi, 0)  # Points inside the stent are brought onto it.
    moved[influenced] += (amount[:, None] * direction)[influenced]
    return moved


def radii(start, target, increment):
    """Pairs (radius, growth), the last growth partial so that the stent ends at the target."""
    count = int(np.ceil(round((target - start) / increment, 9)))
    starts = start + increment * np.arange(count)
    ends = np.minimum(start + increment * np.arange(1, count + 1), target)
    return list(zip(starts, ends - starts, strict=True))


def deployed(vertices, nodes, start, target, increment=0.1, **parameters):
    """All vertices after the last step of algorithm 1."""
    vertices = np.array(vertices, dtype=float)
    for radius, growth in radii(start, target, increment):
        vertices = step(vertices, nodes, radius, growth, **parameters)
    return vertices
