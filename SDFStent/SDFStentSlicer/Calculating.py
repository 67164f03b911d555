"""Calculation of treatments: in a process beside the application, or on a thread of its own where there is none."""

from SDFStentLib.beside import ProcessEnded, treatment_process
from SDFStentLib.plan import TreatedCase, with_sections

from . import Clock
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

    def told(self, found):
        """Measure all, by the vessel's lesions that were found, or by None; yields None until it is done, then returns a `TreatedCase`."""
        yield from self.survey()
        result = yield from inPortions(lambda: self._treatment.result)
        case = TreatedCase(self._vessel, result, found)
        lesions = yield from inPortions(lambda: case.lesions)
        yield from inPortions(
            lambda: with_sections(tuple(one.after for one in lesions or () if one.stents))
        )
        yield from inPortions(lambda: case.told)
        return case


class Elsewhere:
    """Treatment as of `Here` in a `TreatmentProcess`, its survey in a second one meanwhile, if any; this takes over from a process that ends."""

    def __init__(self, process, second, vessel, treatment):
        self._process, self._second = process, second
        self._vessel, self._treatment = vessel, treatment
        self._here, self._last = Here(vessel, treatment), {}
        self._asked = self._alsoAsked = None
        self._isGone = False

    def states(self):
        """As of `Here`."""
        count = 0
        try:
            self._process.begin(self._vessel, self._treatment)
            self._asked = Asked(self._process)
            self._beginSurvey()
            # Ends: as above.
            while (state := (yield from self._asked.answer())) is not None:
                count += 1
                self._last[state.number] = state
                yield state
            return
        except ProcessEnded:
            self._isGone = True
        for state in self._here.states():
            count -= state is not None
            if state is None or count < 0:
                yield state

    def survey(self):
        """As of `Here`; the processes do that by themselves."""
        if self._isGone:
            yield from self._here.survey()

    def told(self, found):
        """As of `Here`."""
        try:
            if not self._isGone:
                survey = yield from self._surveyed()
                isShared = found is not None and self._beginLesions(found)
                self._asked.check()
                self._process.finish(None if isShared else found, survey)
                case = yield from self._asked.answer()
                return case if not isShared else (yield from self._withLesions(case, found))
        except ProcessEnded:
            self._isGone = True
        return (yield from self._here.told(found))

    def _beginSurvey(self):
        try:
            if self._second is not None:
                self._second.survey(self._vessel, self._treatment)
                self._alsoAsked = Asked(self._second)
        except ProcessEnded:
            self._second = None

    def _beginLesions(self, found):
        """Ask the second process for the lesions after treatment; returns whether it could."""
        try:
            if self._second is not None:
                self._alsoAsked.check()
                self._second.left(found, tuple(self._last.values()))
        except ProcessEnded:
            self._second = None
        return self._second is not None

    def _withLesions(self, case, found):
        """Case with the lesions after treatment; yields portions until these are known."""
        try:
            left = yield from self._alsoAsked.answer()
        except ProcessEnded:
            left = None
        case = TreatedCase(self._vessel, case.treatment, found, left)
        yield from inPortions(lambda: case.told)
        return case

    def _surveyed(self):
        """The survey of the second process; None where the first is to make it."""
        try:
            return None if self._second is None else (yield from self._alsoAsked.answer())
        except ProcessEnded:
            self._second = None


class Asked:
    """A request to a process just now; answers come one by one, unless somebody else asks for something."""

    def __init__(self, process):
        self._process, self._number = process, process.number

    def answer(self):
        """The next one; a portion for every look whether there is one. `ProcessEnded` where none will come."""
        try:
            return (yield from waiting(self._look))
        except GeneratorExit:
            if self._process.number == self._number:
                self._process.leave()
            raise

    def check(self):
        """Raise `ProcessEnded` where somebody else has asked for something since."""
        if self._process.number != self._number:
            raise ProcessEnded

    def _look(self):
        self.check()
        return self._process.answer(Clock.wait())


class _Processes:
    """Processes of this application: one deploys, the other one previews; new ones replace those that have ended."""

    def __init__(self):
        self._isWanted, self._kept = True, [None, None]

    @property
    def deploying(self):
        """The process for deployments, None where it cannot be had. It takes a second to start: ask before it is needed."""
        return self._ready(0)

    @property
    def previewing(self):
        """Process for results that are needed sooner; None where it cannot be had."""
        return self._ready(1)

    def _ready(self, number):
        if self._isWanted and (self._kept[number] is None or self._kept[number].has_ended):
            self._kept[number] = treatment_process()
            self._isWanted = self._kept[number] is not None
        return self._kept[number]

    def use(self, isWanted):
        """End all processes, and start new ones on demand, or with False none."""
        for process in self._kept:
            if process is not None:
                process.end()
        self._isWanted, self._kept = isWanted, [None, None]


processes = _Processes()


def calculation(case, mayShare=True):
    """`Elsewhere` or `Here` for a `Case` of the library, and its `Treatment`.

    One that may not share leaves the second process to the previews of another vessel.
    """
    vessel, treatment, process = case.vessel, case.treatment(), processes.deploying
    if process is None:
        return Here(vessel, treatment), treatment
    second = processes.previewing if mayShare else None
    return Elsewhere(process, second, vessel, treatment), treatment
