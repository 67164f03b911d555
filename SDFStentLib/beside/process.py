"""Treatments in a process of their own, beside an application that has to draw.

An application that embeds Python lets one thread calculate at a time, and none while it draws. What
a `TreatmentProcess` is asked for is calculated beside it: the states of a treatment, then all that
is measured of it, to the bit as here.
"""

from __future__ import annotations

import contextlib
import copyreg
import io
import json
import pickle
import secrets
import subprocess
import threading
from collections.abc import Sequence
from dataclasses import replace
from multiprocessing.connection import Connection, Listener
from types import BuiltinFunctionType, FunctionType
from typing import Any, NamedTuple

import numpy as np

from ..interpreter import own_program
from ..plan import Case, TreatedCase
from ..treatment import (
    PreviewedNumbers,
    PreviewState,
    Survey,
    TreatedLesion,
    Treatment,
    TreatmentState,
    Vessel,
)
from ..validation import DeploymentError
from ..vessel import Lesion

PROTOCOL = 5
"""Protocol of pickle; from 5 on an array stays one that cannot be written to."""


NUMBER_BYTES = 8
"""Length of the number before every request."""


class ProcessEnded(Exception):
    """The process is gone; what it was asked for has to be calculated here."""


class Request(NamedTuple):
    """Request to the process; None in each field of other requests. A number alone asks for nothing
    more."""

    number: int
    """Number of the request: answers to earlier ones are not read any more."""
    held: list[Any] | None = None
    """Vessel and its parts, which later messages only name."""
    treatment: Treatment | None = None
    """Treatment to begin,"""
    surveyed: Treatment | None = None
    """or one of which only the survey is wanted."""
    end: tuple[tuple[Lesion, ...] | None, Survey | None] | None = None
    """Lesions of the vessel, and perhaps the survey, with which the grown treatment is measured."""
    grown: tuple[tuple[Lesion, ...], tuple[TreatmentState, ...]] | None = None
    """Lesions of the vessel, and each stent's last state, for the lesions after treatment."""
    previewed: tuple[Case | None, tuple[Lesion, ...]] | None = None
    """Case to preview, None to make what the first preview needs; lesions for its numbers."""


Value = (
    TreatmentState
    | TreatedCase
    | Survey
    | PreviewState
    | tuple[PreviewedNumbers, ...]
    | tuple[TreatedLesion, ...]
)


class Answer(NamedTuple):
    """The process's answer to the request of a number."""

    number: int
    value: Value | Exception | None
    """Value asked for, None after the last state, or the exception that was raised."""


class Shared:
    """Objects that both processes hold, and that messages name by their places among them."""

    def __init__(self) -> None:
        self._held: list[Any] = []
        self._places: dict[int, int] = {}

    def hold(self, objects: Sequence[Any]) -> None:
        """Hold these and no others."""
        self._held, self._places = [], {}
        self.add(objects)

    def add(self, objects: Sequence[Any]) -> None:
        """Hold these objects, too, unless they are held already."""
        for one in objects:
            if id(one) not in self._places:
                self._places[id(one)] = len(self._held)
                self._held.append(one)

    def packed(self, message: Any) -> bytes:
        """A message in bytes."""
        stream, places = io.BytesIO(), self._places

        class Pickler(pickle.Pickler):
            def persistent_id(self, one: Any) -> int | None:
                return places.get(id(one))

            def reducer_override(self, one: Any) -> Any:
                if not _is_plain(one):
                    return NotImplemented
                make, how, state, *more = one.__reduce_ex__(PROTOCOL)
                if isinstance(state, dict):  # a thread may keep more in it while it is packed
                    state = dict(state)
                return (make, how, state, *more)

        Pickler(stream, PROTOCOL).dump(message)
        return stream.getvalue()

    def unpacked(self, content: bytes) -> Any:
        """The message in some bytes, which the other process has packed."""
        held = self._held

        class Unpickler(pickle.Unpickler):
            def persistent_load(self, place: int) -> Any:
                return held[place]

        return Unpickler(io.BytesIO(content)).load()


def _is_plain(one: Any) -> bool:
    """Whether an object is packed as any other, and neither named nor in a way of its kind."""
    kind = type(one)
    ways = kind.__reduce_ex__, kind.__reduce__
    is_named = isinstance(one, (type, FunctionType, BuiltinFunctionType))
    is_usual = ways == (object.__reduce_ex__, object.__reduce__)
    return is_usual and not is_named and kind not in copyreg.dispatch_table


class TreatmentProcess:
    """A process that carries out one treatment after another.

    It is started at once, takes a second to be ready, and ends with this process or `end`.

    Raises
    ------
    DeploymentError
        There is no Python to start a process with.
    """

    def __init__(self) -> None:
        key = secrets.token_bytes(32)
        command, environment = own_program(f"{__package__}.program")
        self._listener = Listener(authkey=key)
        self._connection: Connection | None = None
        self._waiting: list[bytes] = []
        self._shared, self._number = Shared(), 0
        self._vessel: Vessel | None = None
        self._child = subprocess.Popen(
            command,
            stdin=subprocess.PIPE,
            stdout=subprocess.DEVNULL,
            env=environment,
            creationflags=getattr(subprocess, "CREATE_NO_WINDOW", 0),  # only Windows opens one
        )
        assert self._child.stdin is not None
        opening = [self._listener.address, key.hex()]
        self._child.stdin.write(json.dumps(opening).encode() + b"\n")
        self._child.stdin.flush()
        self._starting = threading.Thread(target=self._connect, daemon=True)
        self._starting.start()

    @property
    def pid(self) -> int:
        """The number that the system has given to the process."""
        return self._child.pid

    @property
    def number(self) -> int:
        """The number of what was asked for last; answers to earlier ones are dropped."""
        return self._number

    @property
    def is_ready(self) -> bool:
        """Whether it has been heard of."""
        return self._connection is not None

    @property
    def has_ended(self) -> bool:
        """Whether the process is gone."""
        return self._child.poll() is not None

    def begin(self, vessel: Vessel, treatment: Treatment) -> None:
        """Treat a vessel: `answer` gives states, then None. What it does for another one it drops.

        `ProcessEnded` where the process is gone.
        """
        self._number += 1
        self._hold(vessel)
        self._send(Request(self._number, treatment=treatment))

    def survey(self, vessel: Vessel, treatment: Treatment) -> None:
        """Ask for the survey of a treatment: `answer` gives it. What it does otherwise it drops.

        `ProcessEnded` where the process is gone.
        """
        self._number += 1
        self._hold(vessel)
        self._send(Request(self._number, surveyed=treatment))

    def left(self, lesions: tuple[Lesion, ...], states: tuple[TreatmentState, ...]) -> None:
        """Ask for the lesions after treatment, of a vessel whose survey was asked for.

        `states` are the last ones of every stent; `answer` gives the `TreatedLesion`s after the
        survey. `ProcessEnded` where the process is gone.
        """
        self._send(Request(self._number, grown=(lesions, states)))
        self._shared.add(lesions)

    def preview(self, case: Case, lesions: tuple[Lesion, ...] = ()) -> None:
        """Ask for a preview: `answer` gives its state, then its numbers, by lesions of the vessel.

        `ProcessEnded` where the process is gone.
        """
        self._number += 1
        self._hold(case.vessel)
        self._send(Request(self._number, previewed=(case, lesions)))
        self._shared.add(lesions)

    def prepare(self, vessel: Vessel) -> None:
        """Make what the first preview of a vessel needs."""
        self._hold(vessel)
        self._send(Request(self._number, previewed=(None, ())))

    def _hold(self, vessel: Vessel) -> None:
        if vessel is not self._vessel:
            held = [vessel.surface, *vars(vessel.surface).values(), vessel.centerline, vessel.faces]
            held = [one for one in held if isinstance(one, np.ndarray) or hasattr(one, "__dict__")]
            self._shared.hold([])
            self._send(Request(self._number, held=[replace(vessel), *held]))
            self._shared.hold([vessel, *held])
            self._vessel = vessel

    def finish(self, lesions: tuple[Lesion, ...] | None, survey: Survey | None = None) -> None:
        """Measure what has grown, by the lesions of the vessel: `answer` gives a `TreatedCase`.

        The survey of the treatment is made where none is given. `ProcessEnded` where the process is
        gone.
        """
        self._send(Request(self._number, end=(lesions, survey)))
        self._shared.add(lesions or ())

    def leave(self) -> None:
        """Drop what is being done: nobody waits for it any more."""
        self._number += 1
        with contextlib.suppress(ProcessEnded):
            self._send(Request(self._number))

    def answer(self, seconds: float) -> tuple[Value | None, ...]:
        """The next answer within some seconds: () without one, else one value.

        Raises what the treatment raised, and `ProcessEnded` where the process is gone.
        """
        try:
            connection = self._connected(seconds)
            if connection is None or not connection.poll(seconds):
                return ()
            answer: Answer = self._shared.unpacked(connection.recv_bytes())
        except (OSError, EOFError) as error:
            self.end()
            raise ProcessEnded from error
        if answer.number != self._number:
            return ()
        if isinstance(answer.value, Exception):
            raise answer.value
        return (answer.value,)

    def end(self) -> None:
        """End the process, whatever it does."""
        self._child.kill()
        self._child.wait()
        assert self._child.stdin is not None
        self._child.stdin.close()
        if self._connection is not None:
            self._connection.close()
        self._listener.close()

    def _connect(self) -> None:
        try:
            self._connection = self._listener.accept()
        except (OSError, EOFError):
            return  # ended before it was ready

    def _connected(self, seconds: float) -> Connection | None:
        """Connection, once made, after sending what waits for it."""
        if self._connection is None:
            self._starting.join(seconds)
        if self.has_ended:
            raise ProcessEnded
        if self._connection is not None:
            # Ends: every round takes one away.
            while self._waiting:
                self._connection.send_bytes(self._waiting.pop(0))
        return self._connection

    def _send(self, request: Request) -> None:
        # The number comes first: whether an earlier request is still wanted is known at once by it.
        head = request.number.to_bytes(NUMBER_BYTES, "big")
        self._waiting.append(head + self._shared.packed(request))
        try:
            self._connected(0.0)
        except (OSError, EOFError) as error:
            self.end()
            raise ProcessEnded from error


def treatment_process() -> TreatmentProcess | None:
    """A new process, or None where there is no Python to start one with."""
    try:
        return TreatmentProcess()
    except (DeploymentError, OSError):
        return None
