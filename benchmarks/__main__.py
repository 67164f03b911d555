"""Run the benchmarks one after another, print their tables, write `benchmarks/results.json`.

python -m benchmarks [--quick] [--only NAME ...] [--largest SUBDIVISIONS] [--output FILE]

Each runs in a process of its own, so that none finds another's memory or imports. Tables are in
markdown. With --quick (small sizes, one run) nothing is written unless --output says where; with
--only the other benchmarks' results stay as they are in the file.
"""

from __future__ import annotations

import argparse
import importlib
import importlib.util
import json
import subprocess
import sys
import time
from datetime import datetime, timezone
from pathlib import Path
from tempfile import TemporaryDirectory

from .common import Found, machine, progress
from .sweep import DATA_FOLDER, PROJECT

TITLES = {
    "against_svmorph": "Whole deployments against svmorph 0.1.2",
    "lumen": "The deployed lumen",
    "paper": "The comparison of the paper",
    "flow": "Pressures and flows",
    "trees": "Narrowings in trees",
    "idealized": "Idealized tubes",
}
RESULTS = PROJECT / "benchmarks" / "results.json"
NEEDS_SVMORPH = ("against_svmorph",)


def run_one(name: str, quick: bool, largest: int | None) -> tuple[Found, str]:
    """Numbers and table of one benchmark."""
    command = [sys.executable, "-m", f"benchmarks.{name}"]
    command += ["--quick"] if quick else []
    command += [] if largest is None else ["--largest", str(largest)]
    with TemporaryDirectory() as folder:
        numbers = Path(folder) / "numbers.json"
        # The table is made here: some packages print to standard output on their own.
        command += ["--json", str(numbers)]
        subprocess.run(command, cwd=PROJECT, check=True, stdout=subprocess.DEVNULL)
        found = json.loads(numbers.read_text(encoding="utf-8"))
    return found, importlib.import_module(f"benchmarks.{name}").table(found)


def earlier_results(path: Path, here: Found) -> Found:
    """The results in the file, if it is from this machine."""
    try:
        found = json.loads(path.read_text(encoding="utf-8"))
    except (OSError, ValueError):
        return {}
    return found["benchmarks"] if found.get("machine") == here else {}


def main(arguments: list[str] | None = None) -> int:
    parser = argparse.ArgumentParser(prog="benchmarks", description=__doc__.splitlines()[0])
    parser.add_argument("--quick", action="store_true", help="small sizes, one run each")
    parser.add_argument("--only", nargs="+", choices=list(TITLES), metavar="NAME", help="these")
    parser.add_argument(
        "--largest", type=int, metavar="SUBDIVISIONS",
        help="of the aorto-iliac model (default 4: 4.76 million triangles)",
    )  # fmt: skip
    parser.add_argument("--output", type=Path, help="instead of benchmarks/results.json")
    chosen = parser.parse_args(arguments)
    if not DATA_FOLDER.is_dir():
        parser.error(f"real anatomies not found in {DATA_FOLDER}; set SDFSTENT_DATA")

    here = machine()
    output = chosen.output or (None if chosen.quick else RESULTS)
    results = earlier_results(output, here) if output and chosen.only else {}
    print(f"{here['cpu']}, {here['cores']} cores, {here['memory_gb']} GB, {here['os']}; ", end="")
    print(", ".join(f"{name} {version}" for name, version in here["versions"].items()) + "\n")
    for name in chosen.only or TITLES:
        if name in NEEDS_SVMORPH and not importlib.util.find_spec("svmorph"):
            progress(f"{name}: left out, svmorph is not installed (pip install '.[bench]')")
            continue
        progress(f"-- {name}")
        start = time.perf_counter()
        results[name], text = run_one(name, chosen.quick, chosen.largest)
        results[name]["took_s"] = round(time.perf_counter() - start, 1)
        print(f"### {TITLES[name]}\n\n{text}\n", flush=True)
        if output:
            write(output, here, results)
    return 0


def write(path: Path, here: Found, results: Found) -> None:
    """Write the file, after every benchmark, so that an interrupted run keeps its results."""
    document = {
        "machine": here,
        "date": datetime.now(timezone.utc).strftime("%Y-%m-%d"),
        "benchmarks": results,
    }
    path.write_text(json.dumps(rounded(document), indent=1) + "\n", encoding="utf-8")


def rounded(value: object) -> object:
    """The value with five significant figures, as the rest is noise."""
    if isinstance(value, float):
        return float(f"{value:.5g}")
    if isinstance(value, dict):
        return {key: rounded(item) for key, item in value.items()}
    if isinstance(value, list):
        return [rounded(item) for item in value]
    return value


if __name__ == "__main__":
    sys.exit(main())
