"""Program of a `TreatmentProcess`: carries out the treatments that it is sent, one at a time."""

from __future__ import annotations

import json
import os
import sys
import threading
from multiprocessing.connection import Client, Connection
from queue import SimpleQueue

from ..plan import Case, TreatedCase
from ..treatment import (
    Survey,
    TreatedLesion,
    Treatment,
    TreatmentState,
    Vessel,
    treated_lesions,
)
from ..vessel import Lesion, with_sections
from .process import NUMBER_BYTES, Answer, Request, Shared


class Program:
    """Answers the requests of a connection, the latest of them first."""

    def __init__(self, connection: Connection) -> None:
        self._connection, self._shared = connection, Shared()
        self._requests: SimpleQueue[bytes] = SimpleQueue()
        self._newest = 0
        self._vessel: Vessel | None = None
        self._treatment: Treatment | None = None
        threading.Thread(target=self._receive, daemon=True).start()

    def run(self) -> None:
        """Answer until the connection ends."""
        # Ends with the process, when the other one closes the connection.
        while True:
            self._do(self._shared.unpacked(self._requests.get()))

    def _receive(self) -> None:
        """Read requests at once, so that their sender never waits; exit when it has ended."""
        try:
            # Ends with the connection.
            while True:
                content = self._connection.recv_bytes()
                self._newest = int.from_bytes(content[:NUMBER_BYTES], "big")
                self._requests.put(content[NUMBER_BYTES:])
        except (OSError, EOFError):
            _end()

    def _do(self, request: Request) -> None:
        if request.held is not None:
            self._vessel = request.held[0]
            self._shared.hold(request.held)
            return
        try:
            if request.treatment is not None:
                self._treatment = request.treatment
                self._grow(request.number, request.treatment)
            elif request.surveyed is not None:
                self._tell(Answer(request.number, request.surveyed.survey))
            elif request.end is not None and self._treatment is not None:
                self._finish(request.number, self._treatment, *request.end)
            elif request.grown is not None:
                self._tell(Answer(request.number, self._left(*request.grown)))
            elif request.previewed is not None:
                self._preview(request.number, *request.previewed)
        except Exception as error:  # also a fault of ours: it is told where somebody sees it
            self._tell(Answer(request.number, error))

    def _grow(self, number: int, treatment: Treatment) -> None:
        for state in treatment:
            self._tell(Answer(number, state))
            if self._newest > number:
                return
        self._tell(Answer(number, None))

    def _finish(
        self,
        number: int,
        treatment: Treatment,
        lesions: tuple[Lesion, ...] | None,
        survey: Survey | None,
    ) -> None:
        self._shared.add(lesions or ())
        assert self._vessel is not None
        if survey is not None:
            treatment.survey = survey
        case = TreatedCase(self._vessel, treatment.result, lesions)
        if self._newest == number:
            with_sections(tuple(one.after for one in case.lesions or () if one.stents))
            _ = case.told
            self._tell(Answer(number, case))

    def _left(
        self, lesions: tuple[Lesion, ...], states: tuple[TreatmentState, ...]
    ) -> tuple[TreatedLesion, ...]:
        self._shared.add(lesions)
        assert self._vessel is not None
        before = self._vessel.surface
        after = before.with_points(states[-1].points())
        found = treated_lesions(lesions, [state.placed for state in states], after, before)
        with_sections(tuple(one.after for one in found if one.stents))
        return found

    def _preview(self, number: int, case: Case | None, lesions: tuple[Lesion, ...]) -> None:
        self._shared.add(lesions)
        if case is None:
            assert self._vessel is not None
            self._vessel.preview.prepare()
            return
        state = case.previewed()
        self._tell(Answer(number, state))
        if self._newest == number:
            self._tell(Answer(number, state.numbers(lesions)))

    def _tell(self, answer: Answer) -> None:
        content = self._shared.packed(answer)
        try:
            self._connection.send_bytes(content)
        except OSError:
            _end()


def _end() -> None:
    """End at once: the other process is gone, and nobody waits for what is being calculated."""
    os._exit(0)


def main() -> None:
    """Connect to the parent process, by the address and key on stdin."""
    address, key = json.loads(sys.stdin.readline())
    try:
        connection = Client(address, authkey=bytes.fromhex(key))
    except (OSError, EOFError):
        return  # the other one is gone already
    Program(connection).run()


if __name__ == "__main__":
    main()
