#!/usr/bin/env bash
# slicer-core 5.13.31053, Linux: the priority that is meant for background threads is given to the main one.
#
# vtkSlicerApplicationLogic starts threads for processing and for downloads, which lower their own
# priority so that they do not disturb who works with the application. On Linux a priority belongs to
# a thread, and the one that is lowered is the thread whose number is that of the process: the main
# one. It stays there when the threads have ended; a user without privileges cannot raise it again.
#
# Seen:  before:                    main thread 0
#        with processing threads:   main thread 19
#        after their end:           main thread 19
#        SLICER_BACKGROUND_THREAD_PRIORITY=0 in the environment: 0 throughout
#
# Why it matters: the application starts these threads when it starts. All that a module does in the
# event loop, and every frame, then gets the processor last: with one other busy process for each core
# a drag shows a fraction of the surfaces, and whoever times a module beside other work times that.
set -euo pipefail
[ "$(uname -s)" = Linux ] || { echo "Priorities of threads are told apart on Linux only."; exit 0; }
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
python3 -m venv "$folder/venv"
"$folder/venv/bin/pip" install --quiet --disable-pip-version-check slicer-core==5.13.31053
cat > "$folder/nice.py" <<'PYTHON'
import os
import sys
import time

import slicer


def nice():
    """That of the main thread, whose number is that of the process."""
    return os.getpriority(os.PRIO_PROCESS, os.getpid())


logic = slicer.vtkSlicerApplicationLogic()
before = nice()
logic.CreateProcessingThread()
time.sleep(1.0)
during = nice()
logic.TerminateProcessingThread()
after = nice()
print("before:", before, "with threads:", during, "after:", after)
expected = [int(value) for value in sys.argv[1:]]
if [before, during, after] != expected:
    sys.exit(f"not {expected}: it has changed")
PYTHON
unset SLICER_BACKGROUND_THREAD_PRIORITY
own=$(nice)
"$folder/venv/bin/python" "$folder/nice.py" "$own" 19 19
SLICER_BACKGROUND_THREAD_PRIORITY=0 "$folder/venv/bin/python" "$folder/nice.py" "$own" "$own" "$own"
