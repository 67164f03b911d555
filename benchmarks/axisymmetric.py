"""Steady flow through a round tube by the Navier-Stokes equations, with scikit-fem.

Velocities of second order, pressures of first (Taylor and Hood), Newton's method; the flow comes in
developed. Twice as many elements both ways change the drops by less than a percent. Faster flows
need them: at a Reynolds number of 3,160 in the throat the drop to it rises by 1.5 %, and with
elements as thick at the wall as elsewhere it comes out 11 % too small.
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
import skfem
from skfem.helpers import ddot, dot, grad

DENSITY, VISCOSITY = 1060.0, 0.004
PASCAL_PER_MMHG = 133.322
ACROSS = 10
"""Number of elements from the axis to the wall; they are thinner there, as are layers behind a
throat."""

_STEPS, _ENOUGH, _NEAR = 60, 1e-5, 0.3


def stations(middle: float, half: float, last: float, finest: float) -> np.ndarray:
    """Places along the tube, mm, close together at the throat and behind it."""
    away = [0.0]
    # Ends: steps are at least as long as the finest.
    while away[-1] < last - middle:
        away.append(away[-1] + max(finest, 0.06 * (away[-1] - half)))
    both = np.concatenate([middle - np.array(away[:0:-1]), middle + np.array(away)])
    inner = both[(both > finest) & (both < last - finest)]
    return np.concatenate([[0.0], inner, [last]])


def pressures(
    along: np.ndarray, radius: Callable[[np.ndarray], np.ndarray], flows: list[float]
) -> list[np.ndarray]:
    """Pressure on the axis, mmHg, at places along a tube (n,), mm, by flow in mL/s, rising."""
    straight = skfem.MeshTri.init_tensor(1e-3 * along, np.linspace(0, 1, ACROSS + 1) ** 0.5)
    wall, inlet, axis = (
        straight.facets_satisfying(where, True)
        for where in (lambda x: x[1] > 1 - 1e-9, lambda x: x[0] < 1e-9, lambda x: x[1] < 1e-9)
    )
    z, share = straight.p
    mesh = skfem.MeshTri(np.stack([z, 1e-3 * share * radius(1e3 * z)]), straight.t)
    velocity = skfem.Basis(mesh, skfem.ElementVector(skfem.ElementTriP2()), intorder=5)
    pressure = velocity.with_element(skfem.ElementTriP1())
    fixed = np.concatenate(
        [
            velocity.get_dofs(wall).all(),
            velocity.get_dofs(inlet).all(),
            velocity.get_dofs(axis).all(["u^2"]),
        ]
    )
    fixed = np.unique(fixed)

    @skfem.BilinearForm
    def viscous(u, v, w):
        r = w.x[1]
        return VISCOSITY * (ddot(grad(u), grad(v)) * r + u[1] * v[1] / r)

    @skfem.BilinearForm
    def divergence(u, q, w):
        return -q * ((grad(u)[0, 0] + grad(u)[1, 1]) * w.x[1] + u[1])

    @skfem.BilinearForm
    def carried(u, v, w):
        old = w["old"]
        both = np.einsum("ij...,j...->i...", grad(u), old.value)
        both = both + w["newton"] * np.einsum("ij...,j...->i...", old.grad, u)
        return DENSITY * dot(both, v) * w.x[1]

    @skfem.LinearForm
    def carried_by_itself(v, w):
        old = w["old"]
        return DENSITY * dot(np.einsum("ij...,j...->i...", old.grad, old.value), v) * w.x[1]

    stiff, free = viscous.assemble(velocity), velocity.N
    link = divergence.assemble(velocity, pressure)
    x = np.zeros(free + pressure.N)
    nodes = velocity.doflocs
    is_inlet = np.isin(np.arange(free), velocity.get_dofs(inlet).all(["u^1"]))
    own = 1e-3 * radius(np.zeros(1))[0]
    found = []
    on_axis = np.flatnonzero(mesh.p[1] < 1e-12)
    on_axis = on_axis[np.argsort(mesh.p[0, on_axis])]
    for flow in flows:
        speed = 2e-6 * flow / (np.pi * own**2)
        x[:free][is_inlet] = speed * (1 - (nodes[1, is_inlet] / own) ** 2)
        change = np.inf
        for _ in range(_STEPS):
            # Newton's method is for the end: before that the new velocity is carried by the old
            # one.
            newton = float(change < _NEAR * speed)
            with_old = {"old": velocity.interpolate(x[:free]), "newton": newton}
            momentum = stiff + carried.assemble(velocity, **with_old)
            right = np.zeros(len(x))
            right[:free] = newton * carried_by_itself.assemble(velocity, **with_old)
            system = skfem.bmat([[momentum, link.T], [link, None]], "csr")
            following = skfem.solve(*skfem.condense(system, right, x=x, D=fixed))
            change = np.abs(following[:free] - x[:free]).max()
            x = following
            if change < _ENOUGH * speed:
                break
        else:
            raise RuntimeError(f"no steady flow of {flow:g} mL/s after {_STEPS} steps")
        found.append(x[free:][pressure.nodal_dofs[0, on_axis]] / PASCAL_PER_MMHG)
    return found
