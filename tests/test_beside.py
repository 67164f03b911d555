"""Treatments in a process of their own: to the bit as here, the latest first."""

import os
import signal
import subprocess
import time
from http import HTTPStatus

import numpy as np
import pytest
from child_processes import PROJECT, python

from SDFStentLib.beside import ProcessEnded, TreatmentProcess, treatment_process
from SDFStentLib.beside.process import Shared
from SDFStentLib.interpreter import own_program
from SDFStentLib.plan import Case, Plan, TreatedCase, read_input_files
from SDFStentLib.samples import sample
from SDFStentLib.stent import AlongAxis, AtLesion, Stent
from SDFStentLib.validation import DeploymentError


@pytest.fixture(scope="module")
def vessel():
    return read_input_files(*map(str, sample("branching_pulmonary_artery")), "mm").vessel


@pytest.fixture(scope="module")
def process():
    process = TreatmentProcess()
    yield process
    process.end()


def treatment_at(vessel, offset, diameter=8.5):
    stent = Stent(diameter, placement=AtLesion(1, offset), length=14.0)
    return Case(vessel, Plan(stents=(stent,))).treatment()


def next_of(process):
    until = time.monotonic() + 60
    while not (found := process.answer(0.02)):
        assert time.monotonic() < until
    return found[0]


def states_of(process):
    return list(iter(lambda: next_of(process), None))


def told(process, vessel, treatment):
    process.begin(vessel, treatment)
    states_of(process)
    process.finish(vessel.lesions)
    return next_of(process)


def test_it_gives_what_is_calculated_here(vessel, process):
    process.begin(vessel, treatment_at(vessel, 0.0))
    states = states_of(process)
    process.finish(vessel.lesions)
    there = next_of(process)

    here = treatment_at(vessel, 0.0)
    for one, other in zip(states, here, strict=True):
        assert one.fraction == other.fraction
        assert np.array_equal(one.points(), other.points())
    expected = TreatedCase(vessel, here.result, vessel.lesions)
    for case in (there, expected):
        assert case.told.certificate.passed
    assert there.told.certificate.lumen == expected.told.certificate.lumen
    assert there.told.certificate.sentence() == expected.told.certificate.sentence()
    assert there.told.warnings == expected.told.warnings
    assert there.residual == expected.residual
    for name in ("before", "after"):
        columns = [vars(getattr(case.told.stents[0], name)) for case in (there, expected)]
        assert all(np.array_equal(columns[0][key], columns[1][key]) for key in columns[1])


def test_what_both_hold_is_not_sent_again(vessel, process):
    found = told(process, vessel, treatment_at(vessel, 1.0))
    assert found.vessel is vessel
    assert found.treatment.before is vessel.surface
    assert found.treatment.surface.triangles is vessel.surface.triangles
    assert all(one is other for one, other in zip(found.found, vessel.lesions, strict=True))
    assert not found.treatment.surface.points.flags.writeable


class Whole:
    """An object in which something is kept as soon as its part is packed, as by another thread."""

    def __init__(self):
        self.part, self.name = Part(self), "whole"


class Part:
    def __init__(self, whole):
        self.whole = whole

    def __reduce__(self):
        self.whole.kept_meanwhile = True
        return str, ("packed",)


def test_what_is_packed_may_be_given_more_by_another_thread():
    shared = Shared()
    for _turn in range(2):
        others = [np.sqrt, Stent, len, os.path.join, HTTPStatus.OK, HTTPStatus, (1.5, "a")]
        made = shared.unpacked(shared.packed([Whole(), np.arange(3), *others]))
        assert (made[0].part, made[0].name) == ("packed", "whole")
        assert np.array_equal(made[1], np.arange(3))
        assert made[2:] == others


def test_the_latest_comes_first(vessel, process):
    process.begin(vessel, treatment_at(vessel, 0.0))
    first = next_of(process)
    process.begin(vessel, treatment_at(vessel, 2.0, diameter=9.0))
    states = states_of(process)
    assert states[-1].placed.stent.diameter == 9.0
    assert states[0].placed.stent.diameter != first.placed.stent.diameter


def test_survey_and_lesions_that_another_process_measured_say_the_same(vessel, process):
    other = TreatmentProcess()
    treatment = treatment_at(vessel, 0.5)
    other.survey(vessel, treatment)
    process.begin(vessel, treatment)
    states = states_of(process)
    survey = next_of(other)
    other.left(vessel.lesions, (states[-1],))
    process.finish(None, survey)
    left = next_of(other)
    other.end()
    there, here = next_of(process), treatment_at(vessel, 0.5).result
    told = TreatedCase(vessel, there.treatment, vessel.lesions, left)
    expected = TreatedCase(vessel, here, vessel.lesions)
    assert told.residual == expected.residual
    for one, same in zip(told.lesions, expected.lesions, strict=True):
        assert one.before is same.before
        assert one.stents == same.stents
        assert np.array_equal(one.after.diameters, same.after.diameters)
    for name in ("before", "after", "around_before", "around_after"):
        one, same = (getattr(case.stents[0], name) for case in (there.treatment, here))
        assert np.array_equal(one.inscribed_diameter, same.inscribed_diameter)
    assert [one.sentence() for one in there.treatment.stents[0].branches] == [
        one.sentence() for one in here.stents[0].branches
    ]


def test_a_preview_and_its_numbers_are_those_made_here(vessel, process):
    stent = Stent(8.5, placement=AtLesion(1, 0.3), length=14.0)
    case = Case(vessel, Plan(stents=(stent,)))
    process.prepare(vessel)
    process.preview(case, vessel.lesions)
    process.prepare(vessel)  # as when something else of the vessel is chosen meanwhile
    there, numbers = next_of(process), next_of(process)
    here = case.previewed()
    assert np.array_equal(there.indices, here.indices)
    assert np.array_equal(there.coordinates, here.coordinates)
    measured = treatment_at(vessel, 0.0).result.stents
    assert there.with_covered(numbers, measured) == here.numbers(vessel.lesions, measured)
    assert numbers[0].lesion is vessel.lesions[0]


def test_what_was_left_is_not_told(vessel, process):
    process.begin(vessel, treatment_at(vessel, 0.0))
    next_of(process)
    process.leave()
    until = time.monotonic() + 2
    while time.monotonic() < until:
        assert process.answer(0.05) == ()
    assert told(process, vessel, treatment_at(vessel, 0.0)).told.certificate.passed


def test_vessels_in_turn(vessel, process):
    other = read_input_files(*map(str, sample("arch_with_coarctation")), "mm").vessel
    both = [(vessel, treatment_at(vessel, 0.0)), (other, treatment_at(other, 0.0, 12.0))]
    for own, treatment in both * 2:
        found = told(process, own, treatment)
        assert found.vessel is own
        assert len(found.treatment.surface.points) == len(own.surface.points)
        assert found.told.certificate.lumen[0].prescribed == treatment.stents[0].diameter


def test_what_the_treatment_raises_is_raised_here(vessel, process):
    away = np.array([[500.0, 0.0, 0.0], [510.0, 0.0, 0.0]])
    stent = Stent(8.0, placement=AlongAxis(away))
    process.begin(vessel, Case(vessel, Plan(stents=(stent,))).treatment())
    with pytest.raises(DeploymentError, match="surface"):
        states_of(process)
    assert told(process, vessel, treatment_at(vessel, 0.0)).told.certificate.passed


def test_a_vessel_without_lesions_known(vessel, process):
    process.begin(vessel, treatment_at(vessel, 0.0))
    states_of(process)
    process.finish(None)
    assert next_of(process).lesions is None


def test_a_process_that_was_killed_is_told(vessel):
    process = TreatmentProcess()
    process.begin(vessel, treatment_at(vessel, 0.0))
    next_of(process)
    os.kill(process.pid, signal.SIGKILL)
    with pytest.raises(ProcessEnded):
        states_of(process)
    assert process.has_ended
    with pytest.raises(ProcessEnded):
        process.begin(vessel, treatment_at(vessel, 0.0))


def test_it_may_be_ended_before_it_is_ready():
    process = TreatmentProcess()
    process.end()
    assert process.has_ended
    with pytest.raises(ProcessEnded):
        process.answer(0.0)


@pytest.mark.parametrize("seconds", [0.0, 20.0], ids=["before it is ready", "while it waits"])
def test_it_ends_with_the_one_that_asks(seconds):
    program = f"""
import os, time
from SDFStentLib.beside import TreatmentProcess
process, until = TreatmentProcess(), time.monotonic() + {seconds}
while time.monotonic() < until and not process.is_ready:
    process.answer(0.05)
print(process.pid, flush=True)
os._exit(0)
"""
    done = python(program)
    until = time.monotonic() + 60
    while os.path.exists(f"/proc/{int(done.stdout)}"):
        assert time.monotonic() < until
        time.sleep(0.05)
    assert "Traceback" not in done.stderr


def test_it_ends_in_silence_where_nobody_is_there_for_its_answer():
    """A page that ended beside a treatment left "Broken pipe" with a traceback."""
    program = """
from threading import Event
from SDFStentLib.beside.process import Answer
from SDFStentLib.beside.program import Program
class Gone:
    def recv_bytes(self):
        Event().wait()
    def send_bytes(self, content):
        raise BrokenPipeError
Program(Gone())._tell(Answer(1, None))
print("goes on")
"""
    done = python(program)
    assert (done.stdout, done.stderr) == ("", "")


def test_without_a_python_there_is_none(monkeypatch):
    monkeypatch.setattr("sys.executable", "/opt/application")
    monkeypatch.setenv("PATH", "")
    assert treatment_process() is None


def test_a_process_finds_the_library_that_asks_for_it(monkeypatch):
    """Also where that was found by a path of the application, as in 3D Slicer."""
    monkeypatch.setenv("PYTHONPATH", "first")
    command, environment = own_program("SDFStentLib", "--version")
    assert environment["PYTHONPATH"].split(os.pathsep) == [str(PROJECT), "first"]
    done = subprocess.run(command, env=environment, capture_output=True, text=True, check=True)
    assert done.stdout.startswith("sdfstent")
