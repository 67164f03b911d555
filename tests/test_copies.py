"""What a copy of the process works out for the command line."""

from __future__ import annotations

import subprocess
import sys

import pytest
from child_processes import INTERRUPTIBLE, PATIENCE

pytestmark = pytest.mark.skipif(
    sys.platform != "linux", reason="only Linux copies a process safely"
)

BEGIN = """
import os, signal, sys, threading, time
import numpy as np
from SDFStentLib.cli.copies import InCopy

def none_is_left():
    try:
        os.waitpid(-1, os.WNOHANG)
    except ChildProcessError:
        return True
"""


def said_by(script: str) -> str:
    """What a process of one thread prints; nothing else, and no error."""
    done = subprocess.run(
        [
            sys.executable,
            "-c",
            "import os\nos.environ['OPENBLAS_NUM_THREADS'] = '1'\n" + BEGIN + script,
        ],
        capture_output=True,
        text=True,
        timeout=PATIENCE,
        **INTERRUPTIBLE,
    )
    assert (done.returncode, done.stderr) == (0, "")
    return done.stdout.strip()


def test_what_a_copy_finds_comes_back():
    # Larger than a pipe holds.
    found = said_by("""
with InCopy(lambda: (os.getpid(), np.arange(1_000_000.0))) as copy:
    process, numbers = copy.result()
print(process != os.getpid(), (numbers == np.arange(1_000_000.0)).all(), none_is_left())
""")
    assert found == "True True True"


@pytest.mark.parametrize(
    "ask", ["1 / 0", "sys.exit(3)", "threading.Lock()", "os.kill(os.getpid(), signal.SIGTERM)"]
)
def test_what_fails_in_a_copy_is_left_to_whoever_asks_for_it_here(ask):
    found = said_by(f"""
with InCopy(lambda: {ask}) as copy:
    print(copy.result(), end=" ")
print(none_is_left())
""")
    assert found == "None True"


def test_a_copy_ends_with_its_block():
    found = said_by("""
start = time.monotonic()
try:
    with InCopy(lambda: time.sleep(600)):
        raise KeyboardInterrupt
except KeyboardInterrupt:
    print(time.monotonic() - start < 300, none_is_left())
""")
    assert found == "True True"


def test_a_process_with_threads_is_not_copied():
    found = said_by("""
held = threading.Event()
threading.Thread(target=held.wait).start()
with InCopy(os.getpid) as copy:
    print(copy.result(), none_is_left())
held.set()
""")
    assert found == "None True"


def test_signals_are_handled_as_before_while_there_is_a_copy():
    found = said_by("""
caught = []
signal.signal(signal.SIGTERM, lambda *_: caught.append(os.getpid()))
with InCopy(lambda: time.sleep(600)):
    os.kill(os.getpid(), signal.SIGTERM)
    print(caught == [os.getpid()], signal.pthread_sigmask(signal.SIG_BLOCK, []))
""")
    assert found == "True set()"
