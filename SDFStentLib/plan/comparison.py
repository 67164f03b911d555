"""Several plans of one patient, each carried out by itself, to be seen beside each other."""

from __future__ import annotations

import os
from collections.abc import Callable, Mapping
from dataclasses import dataclass

import numpy as np

from ..units import reason_of
from ..validation import DeploymentError, InputError, check_is_a, in_short
from .inputs import InputFiles, as_planned, plan_files
from .plan import Plan
from .run import PlanResult, as_read, carried_out


@dataclass(frozen=True)
class Alternative:
    """A plan and its result.

    Attributes
    ----------
    name : str
        Name that distinguishes it from the others.
    plan : Plan
    result : PlanResult or None
        As `run_plan` gives it; None when the plan could not be carried out.
    failure : str
        Why not, in a sentence.
    """

    name: str
    plan: Plan
    result: PlanResult | None = None
    failure: str = ""

    @property
    def is_certified(self) -> bool:
        """Whether it was carried out and nothing that was checked has failed."""
        if self.result is None:
            return False
        certificate = self.result.treatment.certificate
        return certificate is None or certificate.passed


@dataclass(frozen=True)
class PlanComparison:
    """Alternatives for one vessel, in the order in which they were given."""

    alternatives: tuple[Alternative, ...]

    @property
    def results(self) -> dict[str, PlanResult]:
        """The results of the plans that could be carried out, by name."""
        return {one.name: one.result for one in self.alternatives if one.result is not None}


def comparison_inputs(
    plans: Mapping[str, Plan], *, accept_changed_inputs: bool = False
) -> dict[str, InputFiles]:
    """Read what `compare` needs; what several plans name alike is read once.

    For a program that reads files elsewhere than it computes. Errors as of `compare`.
    """
    return _inputs(_checked(plans), accept_changed_inputs)


def compare(
    plans: Mapping[str, Plan],
    *,
    inputs: Mapping[str, InputFiles] | None = None,
    accept_changed_inputs: bool = False,
    progress: Callable[[float, str], None] | None = None,
) -> PlanComparison:
    """Carry out several plans of one patient; one that fails keeps no other from being seen.

    The vessel is read once, and its lesions are found once, for all plans that name the same files.

    Parameters
    ----------
    plans : mapping of str to Plan
        Two or more, by name.
    inputs : mapping of str to InputFiles, optional
        As of `comparison_inputs`, where that was called before.
    accept_changed_inputs : bool
        As for `run_plan`.
    progress : callable, optional
        Called with the share that is done, 0 to 1, and the name of the plan.

    Raises
    ------
    InputError
        Fewer than two plans, files that cannot be read or changed since, or plans that are not
        of the same vessel with the same centerline.
    DeploymentError
        None of the plans could be carried out; the message says why the first could not.
    """
    if inputs is None:
        inputs = comparison_inputs(plans, accept_changed_inputs=accept_changed_inputs)
    done = []
    for place, (name, plan) in enumerate(plans.items()):

        def show(fraction: float, place: int = place, name: str = name) -> None:
            if progress is not None:
                progress((place + fraction) / len(plans), name)

        done.append(_carried_out(name, as_read(plan, inputs[name]), inputs[name], show))
    comparison = PlanComparison(tuple(done))
    if not comparison.results:
        first = comparison.alternatives[0]
        raise DeploymentError(
            f"None of the plans could be carried out; {first.name}: {first.failure}"
        )
    return comparison


def _carried_out(
    name: str, plan: Plan, inputs: InputFiles, show: Callable[[float], None]
) -> Alternative:
    try:
        result = carried_out(plan, inputs, lambda state: show(state.fraction))
    except (InputError, DeploymentError) as error:
        return Alternative(name, plan, failure=reason_of(error, plan.units))
    return Alternative(name, plan, result)


def _checked(plans: Mapping[str, Plan]) -> Mapping[str, Plan]:
    if not isinstance(plans, Mapping):
        raise InputError(
            f"plans: expected a mapping of names to plans, got {in_short(plans)}; "
            "name each of them."
        )
    if len(plans) < 2:
        raise InputError(
            f"plans: expected two or more to compare, got {len(plans)}; name another one."
        )
    for name, plan in plans.items():
        check_is_a(name, str, "name of a plan")
        check_is_a(plan, Plan, f"plan {name}")
    return plans


def _inputs(plans: Mapping[str, Plan], accept_changed_inputs: bool) -> dict[str, InputFiles]:
    """Files read for each plan; what several name alike is read once."""
    known: dict[tuple[object, ...], InputFiles] = {}
    found: dict[str, InputFiles] = {}
    for name, plan in plans.items():
        try:
            key = _files_of(plan)
            if key not in known:
                known[key] = plan_files(plan)
            found[name] = as_planned(plan, known[key], accept_changed_inputs=accept_changed_inputs)
        except InputError as error:
            raise error.labeled(f"{name}: ") from error
    _check_same_vessel(found)
    return found


def _files_of(plan: Plan) -> tuple[object, ...]:
    """Key that decides what `plan_files` gives."""
    paths = (
        None if file is None else os.path.realpath(file.path)
        for file in (plan.surface, plan.centerline)
    )
    return (*paths, plan.units, plan.frame, plan.root, plan.reference, plan.names)


def _check_same_vessel(inputs: Mapping[str, InputFiles]) -> None:
    (first, one), *others = inputs.items()
    for name, other in others:
        if (one.surface.sha256, one.surface.units) != (other.surface.sha256, other.surface.units):
            raise InputError(
                f"{first} and {name}: expected plans of one surface in one unit, got "
                f"{one.surface.path} in {one.surface.units} and {other.surface.path} in "
                f"{other.surface.units}; compare plans of the same patient."
            )
    (first, one), *others = [
        (name, read) for name, read in inputs.items() if read.line_file is not None
    ] or [next(iter(inputs.items()))]
    for name, other in others:
        if not _has_same_lesions(one, other):
            raise InputError(
                f"{first} and {name}: expected plans with one centerline, root and reference, got "
                "others; their lesions would not be the same, give both the same centerline."
            )


def _has_same_lesions(one: InputFiles, other: InputFiles) -> bool:
    """Whether the vessel's lesions are found and measured alike."""
    assert one.line_file is not None
    assert other.line_file is not None
    roots = one.vessel.root, other.vessel.root
    marks = one.vessel.reference, other.vessel.reference
    return (
        one.line_file.sha256 == other.line_file.sha256
        and np.array_equal(*np.array(roots))
        and len(marks[0]) == len(marks[1])
        and all(np.array_equal(*pair) for pair in zip(*marks, strict=True))
    )
