"""From files to files through a plan; give a folder as made by `sdfstent demo`."""

import sys
from pathlib import Path

from SDFStentLib import load_plan, run_plan
from SDFStentLib.report import plan_report


def main(folder):
    plan = load_plan(Path(folder) / "plan.json")
    result = run_plan(plan)
    result.write_surface(Path(folder) / "again.vtp", arrays=True)
    report = plan_report(result).as_dict()
    assert report["certificate"]["passed"]
    return report["diameters"]["minimum_lumen"]["after_mm"]


if __name__ == "__main__":
    minimum = main(sys.argv[1] if len(sys.argv) > 1 else "sdfstent-demo")
    assert abs(minimum - 7.0) < 0.1
    print(f"narrowest lumen under the stent: {minimum:.2f} mm")
