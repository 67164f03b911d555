"""Where treatments are calculated: in a process beside the application, or on a thread of its own where there is none."""

from SDFStentLib.beside import ProcessEnded, treatment_process
from SDFStentLib.plan import TreatedCase

from . import Clock
from .Lesions import withSections
from .Portions import inPortions, waiting


class Here:
    """The library's `Treatment` of a `Vessel` on a thread. No nodes in here."""

    def __init__(self, vessel, treatment):
        self._vessel, self._treatment = vessel, treatment

    def states(self):
        """Deploy; yields a `TreatmentState` after every radius step, and None in between."""
        states = iter(self._treatment)
        # Ends: a treatment has as many states as radius steps, whose number is bounded.
        while (state := (yield from inPortions(lambda: next(states, None)))) is not None:
            yield state

    def survey(self):
        """Measure what does not depend on the states; yields None until it is done."""
        yield from inPortions(lambda: self._treatment.survey)

    def told(self, search):
        """Measure all, by what a `LesionSearch` finds, or by None; yields None until it is done, then returns a `TreatedCase`."""
        yield from self.survey()
        result = yield from inPortions(lambda: self._treatment.result)
        case = TreatedCase(self._vessel, result, (yield from _found(search)))
        lesions = yield from inPortions(lambda: case.lesions)
        yield from inPortions(
            lambda: withSections([one.after for one in lesions or () if one.stents])
        )
        yield from inPortions(lambda: case.told)
        return case


class Elsewhere:
    """The same in a `TreatmentProcess`; where that ends, here."""

    def __init__(self, process, vessel, treatment):
        self._process, self._vessel, self._treatment = process, vessel, treatment
        self._here = Here(vessel, treatment)
        self._isGone = False

    def states(self):
        """As of `Here`."""
        count = 0
        try:
            self._process.begin(self._vessel, self._treatment)
            # Ends: as above.
            while (state := (yield from self._answer())) is not None:
                count += 1
                yield state
            return
        except ProcessEnded:
            self._isGone = True
        for state in self._here.states():
            count -= state is not None
            if state is None or count < 0:
                yield state

    def survey(self):
        """As of `Here`; the process does that by itself."""
        if self._isGone:
            yield from self._here.survey()

    def told(self, search):
        """As of `Here`."""
        found = yield from _found(search)
        try:
            if not self._isGone:
                self._process.finish(found)
                return (yield from self._answer())
        except ProcessEnded:
            self._isGone = True
        return (yield from self._here.told(search))

    def _answer(self):
        """The next answer; a portion for every look whether there is one."""
        try:
            return (yield from waiting(lambda: self._process.answer(Clock.wait())))
        except GeneratorExit:
            self._process.leave()
            raise


def _found(search):
    """The lesions that a search finds, or None without one; yields None until they are found."""
    if search is None:
        return None
    yield from search.portions()
    return search.found


class _Process:
    """The one process of this application; started anew where it has ended."""

    def __init__(self):
        self._isWanted, self._process = True, None

    def ready(self):
        """The process, None where it cannot be had. It takes a second to start, so ask before it is needed."""
        if self._isWanted and (self._process is None or self._process.has_ended):
            self._process = treatment_process()
            self._isWanted = self._process is not None
        return self._process

    def use(self, isWanted):
        """Whether there is to be a process from now on; one that runs is ended."""
        if self._process is not None:
            self._process.end()
        self._isWanted, self._process = isWanted, None


process = _Process()


def calculation(case):
    """`Elsewhere` or `Here` for a `Case` of the library, and its `Treatment`."""
    vessel, treatment, there = case.vessel, case.treatment(), process.ready()
    where = Here(vessel, treatment) if there is None else Elsewhere(there, vessel, treatment)
    return where, treatment
