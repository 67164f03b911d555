"""Seeded damages of files of every format: each must end in a sentence or in a surface.

    python -m benchmarks.damaged_files [--quick]

Files are read in processes of their own, a batch in each, within 2.5 GB of addresses: a crash, ten
seconds without an answer, or more than 1 GB of memory is counted with the file that did it. A
damage that no reader can see (another digit of a coordinate) gives another surface, whose points
are finite and whose indices exist.
"""

from __future__ import annotations

import json
import random
import re
import subprocess
import sys
import tempfile
from collections import Counter
from collections.abc import Iterator
from itertools import product
from pathlib import Path

import numpy as np
from vtkmodules.vtkIOLegacy import vtkPolyDataWriter
from vtkmodules.vtkIOXML import vtkXMLPolyDataWriter

from SDFStentLib.files import (
    add_arrays,
    encode_vtp,
    polydata_from_arrays,
    read_surface,
    set_frame_of_polydata,
    write_surface,
)

from .bench_certificate import subdivided
from .common import Found, markdown, progress, run_alone
from .sweep import PROJECT

COUNT = 4800
BATCH = 100
LIMIT_MB, LIMIT_S = 1000, 10
NUMBERS = (
    b"-1", b"0", b"1", b"7", b"255", b"65536", b"2147483648", b"4294967295", b"8589934592",
    b"9223372036854775808", b"1e11", b"1e308", b"nan", b"43.7", b"9" * 4000, b"x", b"",
)  # fmt: skip
WORKER = """
import json, resource, signal, sys, time
from pathlib import Path
resource.setrlimit(resource.RLIMIT_AS, (2_500_000_000, 2_500_000_000))
import numpy as np
from SDFStentLib.files import read_lines, read_surface
from benchmarks.peak import peak_mb
from SDFStentLib.validation import InputError
for path in map(Path, sys.argv[1:]):
    print("begin", path.name, flush=True)
    start = time.perf_counter()
    try:
        if path.name.endswith(".json"):
            found = read_lines(path)
            whole = np.isfinite(found.points).all()
        else:
            found = read_surface(path)
            whole = np.isfinite(found.points).all() and 0 <= found.triangles.min()
            whole = whole and found.triangles.max() < len(found.points)
        outcome = "surface" if whole else "nonsense"
    except InputError as error:
        is_one = str(path) in str(error) and "\\n" not in str(error) and len(str(error)) < 500
        outcome = "sentence" if is_one else f"no sentence: {error}"[:300]
    except BaseException as error:
        outcome = f"{type(error).__name__}: {error}"[:300]
    print(json.dumps([outcome, time.perf_counter() - start, peak_mb()]), flush=True)
"""


def whole_files() -> dict[str, bytes]:
    """One small surface in every format and layout, by the name of a file."""
    ring = np.array([[1.0, 0, 0], [0, 1, 0], [-1, 0, 0], [0, -1, 0], [0, 0, 1], [0, 0, -1]])
    faces = [[a, (a + 1) % 4, 4] for a in range(4)] + [[(a + 1) % 4, a, 5] for a in range(4)]
    points, triangles = subdivided(*subdivided(30 * ring, np.array(faces)))
    arrays = {"label": np.arange(len(points)), "vector": np.ones((len(points), 3), np.float32)}
    polydata = polydata_from_arrays(points, triangles, arrays)
    add_arrays(polydata, {"name": np.array([f"p{n}" for n in range(len(points))])}, None)
    set_frame_of_polydata(polydata, "RAS")
    files = dict(_xml_files(polydata))
    for kind, version in product(("ASCII", "Binary"), (42, 51)):
        writer = vtkPolyDataWriter()
        getattr(writer, f"SetFileTypeTo{kind}")()
        writer.SetFileVersion(version)
        files[f"{kind}-{version}.vtk"] = _written(writer, polydata, "GetOutputStdString")
    files["text.stl"] = _text_stl(points[triangles])
    files |= _other_files(polydata)
    files["text.ply"] = _text_ply(points, triangles)
    files["curve.mrk.json"] = _markups(points[:5])
    return files


def damaged(data: bytes, seed: int) -> bytes:
    """One to three: bytes flipped, cut, inserted, taken out or repeated, numbers replaced."""
    dice = random.Random(seed)
    for _ in range(dice.choice((1, 1, 1, 2, 3))):
        at = dice.randrange(max(len(data), 1))
        # Half of all places in the header, where a damage does most.
        at = at if dice.random() < 0.5 else min(at, dice.randrange(3000))
        size = dice.choice((1, 1, 2, 3, 4, 8, 50, 1000))
        kind = dice.randrange(7)
        if kind == 0:
            flipped = bytes(byte ^ 1 << dice.randrange(8) for byte in data[at : at + min(size, 8)])
            data = data[:at] + flipped + data[at + len(flipped) :]
        elif kind == 1:
            data = data[:at]
        elif kind == 2:
            data = data[:at] + dice.randbytes(size) + data[at:]
        elif kind == 3:
            data = data[:at] + data[at + size :]
        elif kind == 4:
            data = data[: at + size] + data[at : at + size] + data[at + size :]
        else:
            data = _another_number(data, at, dice)
    return data or b" "


def _another_number(data: bytes, at: int, dice: random.Random) -> bytes:
    found = re.compile(rb"-?\d[\d.]*").search(data, at)
    if not found:
        return data
    value = dice.choice(NUMBERS)
    if dice.random() < 0.3 and found[0].isdigit() and len(found[0]) < 18:
        value = b"%d" % (int(found[0]) + dice.choice((-1, 1, 4)))
    return data[: found.start()] + value + data[found.end() :]


def outcomes(
    cases: list[tuple[str, int]], files: dict[str, bytes]
) -> Iterator[tuple[str, int, str, float, float]]:
    """Name, seed, outcome, seconds and MB of each case; a process that dies is started anew."""
    with tempfile.TemporaryDirectory() as folder:
        paths = []
        for name, seed in cases:
            path = Path(folder) / f"{seed}-{name}"
            path.write_bytes(damaged(files[name], seed))
            paths.append(path)
        while paths:
            lines = _answers(paths)
            for (name, seed), line in zip(cases, lines, strict=False):
                yield (name, seed, *line)
            cases, paths = cases[len(lines) :], paths[len(lines) :]


def _answers(paths: list[Path]) -> list[tuple[str, float, float]]:
    """What a process says of these files, up to the one that ended it."""
    command = [sys.executable, "-c", WORKER, *map(str, paths)]
    try:
        run = subprocess.run(command, cwd=PROJECT, capture_output=True, text=True, timeout=300)
        said, end = run.stdout, f"crash {run.returncode}: {run.stderr[-200:]}"
        noise = run.stderr
    except subprocess.TimeoutExpired as error:
        said, end, noise = (error.stdout or b"").decode(), "hang", ""
    lines = [json.loads(line) for line in said.splitlines() if not line.startswith("begin")]
    found = [(outcome, seconds, peak) for outcome, seconds, peak in lines]
    if len(found) < len(paths):
        found.append((end, 0.0, 0.0))
    elif noise:
        found[-1] = (f"noise: {noise[-200:]}", *found[-1][1:])
    return found


def measured(quick: bool, _largest: int | None = None) -> Found:
    """How many damages ended how, the longest time and the most memory."""
    files = whole_files()
    names = sorted(files)
    count = 3 * len(names) if quick else COUNT
    cases = [(names[seed % len(names)], seed) for seed in range(count)]
    counts: Counter[str] = Counter()
    bad, slowest, largest = [], 0.0, 0.0
    for start in range(0, count, BATCH):
        progress(f"{start} of {count}")
        for name, seed, outcome, seconds, peak in outcomes(cases[start : start + BATCH], files):
            is_good = outcome in ("sentence", "surface") and seconds < LIMIT_S and peak < LIMIT_MB
            counts[outcome if is_good else "bad"] += 1
            slowest, largest = max(slowest, seconds), max(largest, peak)
            if not is_good:
                bad.append([name, seed, outcome, seconds, peak])
    return {
        "damages": count,
        "formats": len(names),
        "sentences": counts["sentence"],
        "surfaces": counts["surface"],
        "bad": bad,
        "slowest_s": round(slowest, 3),
        "largest_mb": round(largest),
    }


def table(found: Found) -> str:
    """One row."""
    columns = ("damages", "formats", "sentences", "surfaces", "slowest_s", "largest_mb")
    return markdown((*columns, "bad"), [[*(found[name] for name in columns), len(found["bad"])]])


def _xml_files(polydata: object) -> Iterator[tuple[str, bytes]]:
    layouts = [("Ascii", "None", True), ("Binary", "None", True), ("Binary", "ZLib", True)]
    layouts += list(product(("Appended",), ("None", "ZLib", "LZ4", "LZMA"), (True, False)))
    for number, (mode, compressor, encoded) in enumerate(layouts):
        writer = vtkXMLPolyDataWriter()
        getattr(writer, f"SetDataModeTo{mode}")()
        getattr(writer, f"SetCompressorTypeTo{compressor}")()
        getattr(writer, f"SetHeaderTypeToUInt{'64' if number % 2 else '32'}")()
        writer.SetEncodeAppendedData(encoded)
        writer.SetBlockSize(512)
        name = f"{mode}-{compressor}-{'base64' if encoded else 'raw'}.vtp"
        yield name, _written(writer, polydata, "GetOutputString")


def _other_files(polydata: object) -> dict[str, bytes]:
    with tempfile.TemporaryDirectory() as folder:
        source = Path(folder) / "source.vtp"
        source.write_bytes(encode_vtp(polydata))
        surface = read_surface(source)
        found = {}
        for name in ("binary.stl", "text.obj", "binary.ply"):
            path = Path(folder) / name
            write_surface(path, surface, [], np.zeros((0, 3)))
            found[name] = path.read_bytes()
    return found


def _written(writer: object, polydata: object, result: str) -> bytes:
    writer.SetInputData(polydata)
    writer.SetWriteToOutputString(True)
    writer.Write()
    data = getattr(writer, result)()
    return data.encode() if isinstance(data, str) else bytes(data)


def _text_stl(corners: np.ndarray) -> bytes:
    facets = [
        "facet normal 0 0 0\nouter loop\n"
        + "".join("vertex {:.6g} {:.6g} {:.6g}\n".format(*corner) for corner in facet.tolist())
        + "endloop\nendfacet\n"
        for facet in corners
    ]
    return ("solid a\n" + "".join(facets) + "endsolid a\n").encode()


def _text_ply(points: np.ndarray, triangles: np.ndarray) -> bytes:
    lines = ["ply", "format ascii 1.0", f"element vertex {len(points)}"]
    lines += [f"property double {axis}" for axis in "xyz"]
    lines += [f"element face {len(triangles)}", "property list uchar int vertex_indices"]
    lines += ["end_header", *(" ".join(map(repr, point)) for point in points.tolist())]
    lines += ["3 {} {} {}".format(*corners) for corners in triangles.tolist()]
    return ("\n".join(lines) + "\n").encode()


def _markups(points: np.ndarray) -> bytes:
    placed = [{"id": str(n), "position": p} for n, p in enumerate(points.tolist())]
    curve = {"type": "Curve", "coordinateSystem": "LPS", "controlPoints": placed}
    return json.dumps({"markups": [curve]}, indent=1).encode()


if __name__ == "__main__":
    run_alone(__doc__, measured, table)
