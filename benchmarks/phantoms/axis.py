"""Axes of the synthetic vessels: curves in closed form, parametrized by arc length."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from SDFStentLib.geometry import dot
from SDFStentLib.validation import Floats, InputError, Points, as_point, as_points


@dataclass(frozen=True, eq=False)
class TrueAxis:
    """A curve parametrized by arc length, which continues straight beyond both ends.

    Attributes
    ----------
    length : float
        Arc length from start to end, mm.
    point, tangent, normal : callable
        Functions from arc lengths (n,), mm, to an (n, 3) array. `tangent` and `normal` are
        perpendicular unit vectors; the normal turns as little as a normal can (no twist).
    """

    length: float
    point: Callable[[ArrayLike], Points]
    tangent: Callable[[ArrayLike], Points]
    normal: Callable[[ArrayLike], Points]

    def sampled(self, spacing: float) -> Floats:
        """Equally spaced arc lengths with both ends, at most `spacing` apart, mm."""
        return np.linspace(0.0, self.length, int(np.ceil(self.length / spacing)) + 1)


def planar_axis(
    pieces: Sequence[tuple[float, float]],
    *,
    start: ArrayLike = (0.0, 0.0, 0.0),
    heading: ArrayLike = (0.0, 0.0, 1.0),
    toward: ArrayLike = (1.0, 0.0, 0.0),
) -> TrueAxis:
    """An axis of straight lines and arcs in a plane, each continuing in the direction of the last.

    Parameters
    ----------
    pieces : sequence of (length, curvature)
        Length in mm; curvature in 1/mm, 0 for a line, positive turns toward `toward`.
    start : (3,) array
        First point, mm.
    heading, toward : (3,) arrays
        Direction at the start, and a second direction that spans the plane with it.

    Raises
    ------
    InputError
        `heading` and `toward` span no plane.
    """
    plane = _plane(heading, toward)
    knots, angles, corners = _joints(pieces)
    curvatures = np.array([curvature for _, curvature in pieces])
    origin = as_point(start, "start")
    normal = np.cross(plane[0], plane[1])

    def located(arc_length: ArrayLike) -> tuple[Floats, Floats, Floats]:
        inside = np.clip(np.atleast_1d(np.asarray(arc_length, dtype=float)), 0, knots[-1])
        piece = np.clip(np.searchsorted(knots, inside, side="right") - 1, 0, len(pieces) - 1)
        step = inside - knots[piece]
        turn = curvatures[piece] * step
        # The chord of an arc has a length given by sinc and the direction halfway through the turn.
        chord = (step * np.sinc(turn / (2 * np.pi)))[:, None]
        at = corners[piece] + chord * _directions(angles[piece] + turn / 2)
        return inside, at, _directions(angles[piece] + turn)

    def point(arc_length: ArrayLike) -> Points:
        inside, at, direction = located(arc_length)
        beyond = np.atleast_1d(np.asarray(arc_length, dtype=float)) - inside
        return origin + (at + beyond[:, None] * direction) @ plane

    def tangent(arc_length: ArrayLike) -> Points:
        return located(arc_length)[2] @ plane

    def constant_normal(arc_length: ArrayLike) -> Points:
        return np.tile(normal, (np.size(arc_length), 1))

    return TrueAxis(float(knots[-1]), point, tangent, constant_normal)


def helical_axis(coil_radius: float, pitch: float, turns: float) -> TrueAxis:
    """A helix about the z axis.

    Parameters
    ----------
    coil_radius : float
        Distance of the axis from the z axis, mm.
    pitch : float
        Rise per turn, mm.
    turns : float
        Number of turns, may be a fraction.
    """
    rise = pitch / (2 * np.pi)
    speed = float(np.hypot(coil_radius, rise))
    length = 2 * np.pi * turns * speed
    torsion = rise / speed**2

    def frame(arc_length: ArrayLike) -> tuple[Floats, Floats, Points, Points, Points]:
        wanted = np.atleast_1d(np.asarray(arc_length, dtype=float))
        inside = np.clip(wanted, 0, length)
        cosine, sine = np.cos(inside / speed), np.sin(inside / speed)
        zero, one = np.zeros_like(cosine), np.ones_like(cosine)
        outward = np.stack([cosine, sine, zero], axis=1)
        along = np.stack([-coil_radius * sine, coil_radius * cosine, rise * one], axis=1) / speed
        across = np.stack([rise * sine, -rise * cosine, coil_radius * one], axis=1) / speed
        return inside, wanted - inside, outward, along, across

    def point(arc_length: ArrayLike) -> Points:
        inside, beyond, outward, along, _ = frame(arc_length)
        height = np.multiply.outer(rise * inside / speed, [0.0, 0.0, 1.0])
        return coil_radius * outward + height + beyond[:, None] * along

    def tangent(arc_length: ArrayLike) -> Points:
        return frame(arc_length)[3]

    def untwisted_normal(arc_length: ArrayLike) -> Points:
        # The Frenet frame turns at the rate of the torsion; turning back leaves no twist.
        inside, _, outward, _, across = frame(arc_length)
        back = (torsion * inside)[:, None]
        return np.cos(back) * outward + np.sin(back) * across

    return TrueAxis(length, point, tangent, untwisted_normal)


def narrowing(
    arc_length: ArrayLike, center: float, half_length: float, depth_fraction: float
) -> Floats:
    """Factor on the radius of a smooth stenosis: 1 outside, 1 - depth at its throat.

    A raised cosine, `1 - depth (1 + cos(pi (s - center) / half_length)) / 2`.

    Parameters
    ----------
    arc_length : (n,) array
        Positions s along the axis, mm.
    center, half_length : float
        Position of the throat and its distance to either end of the stenosis, mm.
    depth_fraction : float
        Loss of diameter at the throat, 0 to 1.
    """
    offset = np.clip((np.asarray(arc_length, dtype=float) - center) / half_length, -1, 1)
    return np.asarray(1 - depth_fraction * (1 + np.cos(np.pi * offset)) / 2)


def inscribed_radii(axis: TrueAxis, radius: Callable[[Floats], Floats], at: ArrayLike) -> Floats:
    """Radius of the largest sphere around each axis point that the tube's wall holds.

    The wall is made of circles in the planes across the axis; where the radius changes along
    the axis, the nearest circle is not the one of the point itself, and the sphere is smaller
    than the circle. The end caps are not counted as wall.

    Parameters
    ----------
    axis : TrueAxis
        The tube's axis.
    radius : callable
        Radius of the circle by arc length, mm.
    at : (n,) array
        Arc lengths of the sphere centers, mm.

    Returns
    -------
    (n,) array
        Radii, mm, to better than 1e-4.
    """
    centers = as_points(axis.point(at))
    # Circles every 1 % of the radius: the sphere errs by less than that squared over 8.
    samples = axis.sampled(0.02 * float(np.min(radius(axis.sampled(0.5)))))
    rings, tangents, radii = axis.point(samples), axis.tangent(samples), radius(samples)
    found = np.empty(len(centers))
    for index, center in enumerate(centers):
        offset = center - rings
        height = dot(offset, tangents)
        eccentricity = np.sqrt(np.maximum(dot(offset, offset) - height**2, 0))
        found[index] = np.hypot(height, radii - eccentricity).min()
    return np.minimum(found, radius(np.atleast_1d(np.asarray(at, dtype=float))))


def _plane(heading: ArrayLike, toward: ArrayLike) -> Floats:
    first, second = as_point(heading, "heading"), as_point(toward, "toward")
    if np.linalg.norm(np.cross(first, second)) < 1e-6 * (first @ first + second @ second):
        raise InputError(
            f"toward: expected a direction that differs from heading {tuple(first)}, "
            f"got {tuple(second)}; choose one across it."
        )
    first = first / np.linalg.norm(first)
    second = second - (second @ first) * first
    return np.stack([first, second / np.linalg.norm(second)])


def _directions(angles: Floats) -> Floats:
    # Rounded so that a quarter turn is exact, and a cap after it lies in one coordinate plane.
    return np.round(np.stack([np.cos(angles), np.sin(angles)], axis=-1), 15)


def _joints(pieces: Sequence[tuple[float, float]]) -> tuple[Floats, Floats, Floats]:
    """Arc length, direction angle and position in the plane where each piece starts."""
    knots, angles, corners = [0.0], [0.0], [np.zeros(2)]
    for length, curvature in pieces:
        turn = length * curvature
        chord = length * np.sinc(turn / (2 * np.pi))
        corners.append(corners[-1] + chord * _directions(np.array(angles[-1] + turn / 2)))
        knots.append(knots[-1] + length)
        angles.append(angles[-1] + turn)
    return np.array(knots), np.array(angles), np.array(corners)
