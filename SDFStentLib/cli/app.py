"""The command `app`: starts the server of SDFStentApp, which lives beside the library."""

from __future__ import annotations

import argparse
import importlib
import os
from importlib.util import find_spec
from pathlib import Path
from typing import Any

from ..plan import load_plan
from ..scan_formats import SCAN_SUFFIXES
from ..validation import InputError
from .console import Console

NEEDED = ("slicer", "trame", "trame_rca", "aiohttp", "SDFStentApp")
"""Packages that the extra installs, and the package of the page itself."""


def app_command(options: argparse.Namespace, _console: Console) -> int:
    """Serve pages until Ctrl-C."""
    opening = _opening(options)
    missing = [name for name in NEEDED if find_spec(name) is None]
    if missing:
        raise InputError(
            f"expected the packages of the extra app, {', '.join(missing)} is missing; "
            "install them: pip install 'sdfstent[app]'."
        )
    serving: Any = importlib.import_module("SDFStentApp.serving")
    settings = serving.ServerSettings(
        host=options.host,
        port=options.port,
        opens_browser=not options.no_browser,
        kept_s=options.keep,
        most_pages=options.pages,
        plans=_plans(options.plans),
        opening=opening,
    )
    try:
        serving.serve(settings, lambda line: print(line, flush=True))
    except OSError as error:
        raise InputError(
            f"{options.host}:{options.port}: expected an address that is free, got another "
            f"({error.strerror}); choose another --port or --host."
        ) from error
    return 0


def _plans(named: str | None) -> Path | None:
    """The folder in which plans are kept: the named one, none for `none`, else the usual one."""
    if named == "none":
        return None
    kept: Any = importlib.import_module("SDFStentApp.kept")
    folder: Path = Path(named).absolute() if named else kept.usual_folder()
    try:
        folder.mkdir(parents=True, exist_ok=True, mode=0o700)
    except OSError as error:
        raise InputError(
            f"--plans: expected a folder that can be made, got {folder} ({error.strerror}); "
            "name another, or none."
        ) from error
    return folder


def _opening(options: argparse.Namespace) -> dict[str, Any]:
    """The settings with which every page begins; paths are absolute, for a process elsewhere."""
    for folder in options.folder:
        if not os.path.isdir(folder):
            raise InputError(f"{folder}: expected a folder, got none; correct --folder.")
    _check_range(options)
    given = options.input
    name = "" if given is None else os.fspath(given).lower()
    is_plan, is_surface = name.endswith(".json"), not name.endswith((".json", *SCAN_SUFFIXES))
    if options.demo and given is not None:
        raise InputError("--demo: expected no file beside it, got one; leave one of both out.")
    if options.centerline is not None and (given is None or not is_surface):
        raise InputError(
            "--centerline: expected a surface beside it, got none; name the surface first."
        )
    if options.units != "mm" and (given is None or not is_surface):
        raise InputError(
            "--units: expected a surface beside it, got none; other files name their own unit."
        )
    for path in (given, options.centerline):
        if path is not None and not os.path.isfile(path):
            raise InputError(f"{path}: expected a file, got none; correct the path.")
    if is_plan:
        load_plan(given)
    return {
        "demo": options.demo,
        "input": given and os.path.abspath(given),
        "centerline": options.centerline and os.path.abspath(options.centerline),
        "units": options.units,
        "folders": [os.path.abspath(folder) for folder in options.folder],
    }


def _check_range(options: argparse.Namespace) -> None:
    if not 0 <= options.port <= 65535:
        raise InputError(f"--port: expected 0 to 65535, got {options.port}; choose another.")
    if options.pages < 1:
        raise InputError(f"--pages: expected at least 1, got {options.pages}; allow one.")
    if not 0 <= options.keep <= 86400:
        raise InputError(f"--keep: expected 0 to 86400 s, got {options.keep:g}; choose another.")
