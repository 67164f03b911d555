"""Scripts that solve the cases of a folder: on a laptop, and on a cluster."""

from __future__ import annotations

from collections.abc import Sequence

from .solver_file import PRESSURES, RESULTS, Steps

STEADY = 0.002
"""Part of the inlet pressure within which it has to stay."""

_RUN = """\
#!/bin/sh
# Solves the cases of this folder, one after the other: sh run.sh
# PROCESSES=4 sh run.sh takes so many cores; SOLVER names another svmultiphysics than the PATH's.
set -u
cd "$(dirname "$0")" || exit 1
processes=${PROCESSES:-@processes@}
solver=${SOLVER:-svmultiphysics}
pause=${PAUSE:-5}

# Writes the step to stop at, the next one that is saved, once the inlet pressure stays.
stop_when_steady() {
  tail -n "$1" @pressures@ 2>/dev/null | awk -v n="$1" -v every="$2" '
    NF > 2 && $1 ~ /^[0-9]+$/ {
      if (!rows++ || $3 > high) high = $3
      if (rows == 1 || $3 < low) low = $3
      size = $3 < 0 ? -$3 : $3; step = $1
    }
    END { if (rows == n && step >= 2 * n && high - low <= @steady@ * size)
            print (int(step / every) + 1) * every }' > stop.new
  if [ -s stop.new ] && [ ! -e STOP_SIM ]; then mv stop.new STOP_SIM; else rm -f stop.new; fi
}

# The case, the steps over which pressure has to stay (0 for a wave), and from one that is saved
# to the next.
solve() {
  echo "$1"
  cd "$1" || exit 1
  rm -rf @results@ STOP_SIM
  if [ "$processes" -gt 1 ]; then
    mpiexec -n "$processes" "$solver" solver.xml > solver.log 2>&1 &
  else
    "$solver" solver.xml > solver.log 2>&1 &
  fi
  child=$!
  trap 'kill $child 2>/dev/null; exit 130' INT TERM
  while kill -0 $child 2>/dev/null; do
    if [ "$2" -gt 0 ]; then stop_when_steady "$2" "$3"; fi
    sleep "$pause"
  done
  wait $child || { echo "$1: the solver ended with code $?, see $1/solver.log" >&2; exit 1; }
  cd - > /dev/null || exit 1
}

@cases@
"""

_JOB = """\
#!/bin/bash
#SBATCH -J sdfstent
#SBATCH -N 1
#SBATCH -n 24
#SBATCH -t 24:00:00
# Load the modules with which svMultiPhysics was built here, then: sbatch job.sbatch
cd "${SLURM_SUBMIT_DIR:-.}" || exit 1
PROCESSES="${SLURM_NTASKS:-24}" PAUSE=30 exec sh run.sh
"""


def scripts_of(cases: Sequence[tuple[str, Steps]], processes: int) -> dict[str, str]:
    """`run.sh` and `job.sbatch`, by name.

    Parameters
    ----------
    cases : sequence of folders and their steps
        In the order in which they are solved.
    processes : int
        That `run.sh` takes.
    """
    told = {
        "processes": str(processes),
        "pressures": PRESSURES,
        "results": RESULTS,
        "steady": f"{STEADY:g}",
        "cases": "\n".join(f"solve {n} {steps.window} {steps.save_every}" for n, steps in cases),
    }
    text = _RUN
    for name, value in told.items():
        text = text.replace(f"@{name}@", value)
    return {"run.sh": text, "job.sbatch": _JOB}
