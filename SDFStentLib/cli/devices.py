"""The command `devices`."""

from __future__ import annotations

import argparse

from ..plan import device_document, device_named, device_table
from ..report import device_rows, device_sentence, document_json
from ..validation import one_line
from .console import Console


def devices_command(options: argparse.Namespace, _console: Console) -> int:
    """List the devices that are known, or tell all that is known of one."""
    if options.name is None:
        devices = device_table(options.device_table)
    else:
        devices = (device_named(options.name, options.device_table),)
    if options.json:
        listed = [device_document(device) for device in devices]
        print(document_json({"devices": listed}), end="")
    elif options.name is None:
        for device in devices:
            print(one_line(device_sentence(device)))
    else:
        for name, text in device_rows(devices[0]):
            print(one_line(f"{name}: {text}"))
    return 0
