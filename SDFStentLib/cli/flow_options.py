"""The options of the command `flow`, those that others have left out."""

from __future__ import annotations

import argparse

from .option_table import add_table


def add_flow(command: argparse.ArgumentParser) -> None:
    """What it is for, what is known of the patient, and what is written."""
    command.description = (
        "Pressures and flows in a vessel tree before a plan and after it: the pressure at the "
        "inlet, the drop over each narrowing and the flow to each main branch, with their ranges, "
        "by a network of the vessels. Methods, sources and limits: docs/flow.md."
    )
    add_table(command, "--centerline FILE  any form", required=True)
    add_table(
        command,
        """\
--plan PLAN  what is done to the vessel; without it only what is before is told
--root X Y Z  the end of the centerline near this point is proximal; a plan has its own
--names F  JSON: what vessels are called, each by a place in it or the face at its end
""",
    )
    add_table(
        command.add_argument_group("what is known before treatment"),
        """\
--mean-flow Q  with its unit, such as 41.7mL/s or 2.5L/min
--peak-flow Q  told apart from the mean
--wave F  CSV of one cycle, rows of s and flow under a header with the unit; scaled to --mean-flow
--inlet-pressure P  mean in the main artery, mmHg
--wedge W  mean pressure beyond the lungs, mmHg
--split-right S  share of the flow to the right, such as 0.8
--right X Y Z  a place in the right main branch, where the frame of the file does not tell
""",
    )
    add_table(
        command.add_argument_group("output"),
        """\
--json F  all numbers
--report F ...  .json or .html; may be repeated
--export-0d DIR  the networks as before.json and after.json for svZeroDSolver
""",
    )
