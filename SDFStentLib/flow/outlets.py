"""Outlets of each main branch, and their resistances by the patient's pressures."""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from ..geometry import Line
from ..units import Frame
from ..validation import Flags, Floats, InputError, Points, as_place, place_words
from .blocks import PASCAL_PER_MMHG, PER_ML
from .channels import Channel
from .known import Known
from .network import Costs, Network, Outlets, lost_to, steady, steady_states
from .tree import Tree

MAIN = 0.1
"""Share of the outlets, weighted, from which a branch is a main one: that of the narrowest left
pulmonary artery of the anatomies, 20 % of the flow, is above it, and side branches are below."""

OTHERS = "other outlets"
"""Outlets of neither main branch."""

FIRM = 1e4
"""Outlet resistance over the vessel's without known pressures: shares are fixed."""

NOTHING = 1e-6
"""Negligible part of the known pressure: outlets that cost no more at the mean flow cost
nothing."""


class SideClues(NamedTuple):
    """Clues that tell the main branches apart."""

    frame: Frame | None = None
    """Patient frame, which defines the right side."""
    right: Points | None = None
    """(3,) a place in the right one, mm."""
    names: Sequence[str | None] = ()
    """Names by the user of the branches of the centerline, each in its place."""


NOTHING_KNOWN = SideClues()


class Sides(NamedTuple):
    """The two main branches; other outlets are of neither."""

    names: tuple[str, str]
    blocks: tuple[int, int]
    """The blocks with which they begin."""
    outlets: Flags
    """(2, k) which are theirs."""
    is_known: bool
    """Whether the second one is known to be the right one."""
    places: Points
    """(2, 3) in the middle of these blocks, mm."""

    @property
    def leave_out(self) -> bool:
        """Whether the vessel has outlets of neither main branch."""
        return not bool(self.outlets.any(axis=0).all())

    def flows(self, tree: Tree, through: Floats) -> Floats:
        """Flows (t, 3) to both sides and to other outlets, by those through all blocks (t, n)."""
        at_outlets = tree.signs[tree.outlets] * through[:, tree.outlets]
        # From inlets and through chords blood may come there, too.
        own = through[:, self.blocks] if tree.is_plain else at_outlets @ self.outlets.T
        others = at_outlets[:, ~self.outlets.any(axis=0)].sum(axis=1)
        return np.column_stack([own, others])


def sides_of(
    channels: Sequence[Channel],
    tree: Tree,
    weights: Floats,
    clues: SideClues = NOTHING_KNOWN,
) -> Sides | None:
    """The main branches, left and right where that is known; None for a vessel without.

    Else the larger one, by the weights of its outlets, comes first. Where the user names both they
    have these names. They begin at the first junction from the
    inlet of which a second branch leads to `MAIN`.

    Parameters
    ----------
    channels : sequence of Channel
    tree : Tree
    weights : (k,) array
        Weights of the outlets.
    clues : SideClues, optional
    """
    shares = np.zeros(len(channels))
    shares[tree.outlets] = weights / weights.sum()
    shares, number = tree.summed(shares), tree.order[0]
    # Ends: at an outlet.
    while True:
        below = np.flatnonzero(tree.above == number).tolist()
        below.sort(key=lambda k: -shares[k])
        if not below:
            return None
        if len(below) > 1 and shares[below[1]] >= MAIN:
            break
        number = below[0]
    first, second = below[:2]
    turned = _is_right(channels, tree, (first, second), clues.frame, clues.right)
    pair = (second, first) if turned else (first, second)
    wide = ("larger main branch", "smaller main branch")
    names = wide if turned is None else ("left", "right")
    if clues.names:
        # A limb between two inlets may be called after one of them: rather after its outlet.
        ends = pair if tree.is_plain else [_widest(tree, weights, number) for number in pair]
        one, other = (clues.names[int(channels[number].branch[-1])] for number in ends)
        if one and other and one != other:
            names = one, other
    lines = [channels[number].points for number in pair]
    places = np.array([line[len(line) // 2] for line in lines])
    return Sides(names, pair, tree.leads_to[list(pair)], turned is not None, places)


def _widest(tree: Tree, weights: Floats, number: int) -> int:
    """Block at the widest outlet that one leads to."""
    return int(tree.outlets[np.argmax(np.where(tree.leads_to[number], weights, -1.0))])


def _is_right(
    channels: Sequence[Channel],
    tree: Tree,
    pair: tuple[int, int],
    frame: Frame | None,
    right: Points | None,
) -> bool | None:
    """Whether the first of two branches is the right one; None where nothing tells."""
    if right is not None:
        near = [Line(one.points).nearest(right[None]).distances[0] for one in channels]
        number = int(np.argmin(near))
        if near[number] > np.nanmax(channels[number].section, initial=0.0):
            raise InputError(
                f"flow: expected a place in the right main branch, got {place_words(right)}",
                place=as_place(right),
                end=f", {near[number]:.0f} mm from the vessel; name one in it.",
            )
        # Ends: at the root.
        while number >= 0 and number not in pair:
            number = int(tree.above[number])
        if number < 0:
            raise InputError(
                f"flow: expected a place in one of the two main branches, got {place_words(right)}",
                place=as_place(right),
                end=" before they part; name a place beyond their junction.",
            )
        return number == pair[0]
    if frame is None:
        return None
    ends = np.array([channels[number].points[-1, 0] for number in tree.outlets])
    first, second = (float(ends[tree.leads_to[number]].mean()) for number in pair)
    return first > second if frame == "RAS" else first < second


def _of_the_right(count: int, sides: Sides | None, known: Known) -> Flags:
    """Mask (k,) of the outlets to the right, which share a known split; of none without one."""
    if known.split_right is None:
        return np.zeros(count, dtype=bool)
    assert sides is not None
    return sides.outlets[1]


def outlet_shares(weights: Floats, sides: Sides | None, known: Known) -> Floats:
    """Shares (k,) of the flow by the weights of the outlets, and by the split where it is known."""
    is_right, shares = _of_the_right(len(weights), sides, known), weights / weights.sum()
    if known.split_right is not None:
        for which, part in ((is_right, known.split_right), (~is_right, 1 - known.split_right)):
            shares[which] *= part / shares[which].sum()
    return shares


def fitted_outlets(network: Network, weights: Floats, sides: Sides | None, known: Known) -> Outlets:
    """Outlets that give the known pressures and split at the known flow, before treatment.

    Resistances go with 1 / weights, by a factor for the right and another for all others. Without
    pressures they are `FIRM`, so that the flow is shared by the weights.

    Raises
    ------
    InputError
        Pressures that cannot drive the flow through this vessel.
    """
    is_right = _of_the_right(len(weights), sides, known)
    shares = outlet_shares(weights, sides, known)
    flow = PER_ML * known.mean
    if not known.has_pressures:
        most = flow if known.wave is None else PER_ML * np.abs(known.wave.flow).max()
        return firm_outlets(network, shares, flow, most)
    fit = _Fit(network, shares, is_right, known)
    lost = lost_to(network, steady(network, firm_outlets(network, shares, flow, flow), flow).flow)
    lost = lost[network.tree.outlets]
    left = [float(fit.whole - np.average(lost[one], weights=shares[one])) for one in fit.groups]
    return fit.outlets(fit.factors(left))


class _Fit:
    """Factors of the resistances of one or two groups of outlets, the right ones last: the pressure
    that they take of the mean flow, Pa, as a logarithm."""

    def __init__(self, network: Network, shares: Floats, is_right: Flags, known: Known) -> None:
        assert known.inlet is not None
        assert known.wedge is not None
        self._network, self._shares, self._is_right = network, shares, is_right
        self._known, self._inlet, self._wedge = known, known.inlet, PASCAL_PER_MMHG * known.wedge
        self.whole = PASCAL_PER_MMHG * (known.inlet - known.wedge)
        self.groups = [g for g in (~is_right, is_right) if g.any()]
        self._flows, self._weights = known.spread(len(network.tree.inlets))

    def outlets(self, factors: Floats) -> Outlets:
        resistance = 1 / (PER_ML * self._known.mean * self._shares)
        for group, factor in zip(self.groups, factors, strict=True):
            resistance[group] *= np.exp(factor)
        return Outlets(resistance, self._wedge)

    def missed(self, factors: Floats) -> Floats:
        """The errors of the pressure at the inlet, over it, and of the split."""
        at = self.outlets(factors)
        flows = PER_ML * self._flows
        found = steady_states([(self._network, at, one) for one in flows])
        inlet = self._weights @ [one.inlet for one in found] / PASCAL_PER_MMHG
        wrong = [float(inlet) / self._inlet - 1]
        if len(self.groups) > 1:
            ends = self._network.tree.outlets
            right = [one.flow[ends][self._is_right].sum() for one in found]
            coming = flows if flows.ndim == 1 else flows.sum(axis=1)
            split = self._weights @ right / (self._weights @ coming)
            wrong.append(float(split) - (self._known.split_right or 0.0))
        return np.array(wrong)

    def factors(self, left: Sequence[float]) -> Floats:
        """Factors that miss nothing.

        From what the vessel leaves of the pressure at the mean flow, Pa, where it leaves some; a
        wave may cost far more than its mean flow, and less with other shares.
        """
        # Late: scipy costs what a first frame should not pay.
        from scipy.optimize import root

        if min(left) > 0:
            found = np.asarray(root(self.missed, np.log(left), tol=1e-10).x)
            if np.abs(self.missed(found)).max() <= 1e-6:
                return found
        return self._between()

    def _between(self) -> Floats:
        """The root by halving: the inlet pressure rises with the resistance of every outlet."""
        from scipy.optimize import brentq

        ends = np.log([NOTHING * self.whole, self.whole / min(map(self._share_of, self.groups))])

        def both(factor: float) -> Floats:
            """The factors with the known split, of which the first is given."""
            if len(self.groups) == 1:
                return np.array([factor])

            def beside(other: float) -> float:
                return float(self.missed(np.array([factor, other]))[1])

            low, high = map(float, ends)
            if beside(low) <= 0:
                return np.array([factor, low])
            # Ends: nothing flows where that resists ever more.
            while beside(high) > 0:
                high += 2
            return np.array([factor, brentq(beside, low, high)])

        def above(factor: float) -> float:
            wrong = self.missed(both(factor))
            # Too little goes to the right, whatever that resists: the others resist too little.
            return -1.0 if len(wrong) > 1 and wrong[1] < -1e-6 else float(wrong[0])

        low, high = map(float, ends)
        found = both(low if above(low) > 0 else brentq(above, low, high, xtol=1e-12))
        missed = self.missed(found)
        if np.abs(missed).max() > 1e-6:
            raise self._contradiction(self.whole + PASCAL_PER_MMHG * self._inlet * float(missed[0]))
        return found

    def _share_of(self, group: Flags) -> float:
        return float(self._shares[group].sum())

    def _contradiction(self, lost: float) -> InputError:
        known = self._known
        split = (
            "" if known.split_right is None else f" with {100 * known.split_right:g} % to the right"
        )
        what = "" if known.wave is None else "a wave of "
        return InputError(
            f"pressures: expected more than the vessel itself costs, got {known.inlet:g} at the "
            f"inlet and {known.wedge:g} mmHg beyond the lungs, where {what}{known.mean:.3g} mL/s"
            f"{split} cost about {lost / PASCAL_PER_MMHG:.1f} mmHg on the way to the outlets; "
            "correct flow, split or pressures."
        )


def firm_outlets(network: Costs, shares: Floats, flow: float, most: float) -> Outlets:
    """Outlets that share up to so much flow whatever the vessel costs."""
    through = network.tree.carried(most, shares)
    if len(network.tree.chords):
        # All of it through one of the limbs that meet again would cost far more.
        through = steady(network, _firm(network, shares, flow, through), most).flow
    return _firm(network, shares, flow, through)


def _firm(network: Costs, shares: Floats, flow: float, through: Floats) -> Outlets:
    lost = lost_to(network, through).max()
    return Outlets(FIRM * max(float(lost), 1.0) / (flow * shares), 0.0)
