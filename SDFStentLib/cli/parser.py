"""A parser that says in one sentence what is wrong, and a short help beside the long one."""

from __future__ import annotations

import argparse
import re
from collections.abc import Sequence
from difflib import get_close_matches
from typing import Any, NoReturn


class Parser(argparse.ArgumentParser):
    """A parser that says in one sentence what is wrong."""

    def parse_known_args(self, args=None, namespace=None):  # type: ignore[no-untyped-def]
        """As inherited, but what is left over is an error of the command that it was given to."""
        options, rest = super().parse_known_args(args, namespace)
        if rest:
            self.error(f"unrecognized arguments: {' '.join(rest)}{self._nearest(rest)}")
        return options, rest

    def _nearest(self, words: Sequence[str]) -> str:
        """Which option may have been meant by the first one that is none."""
        names = [word.split("=")[0] for word in words if word.startswith("-")]
        known = re.findall(r"(?<![\w-])--[a-z0-9][\w-]*", self.format_help())
        if not names:
            return ""
        begun = sorted((one for one in known if one.startswith(names[0])), key=len)
        near = begun or get_close_matches(names[0], known, 1)
        return f", the nearest option is {near[0]}" if near else ""

    def error(self, message: str) -> NoReturn:
        """End with the sentence on stderr and exit code 2."""
        message = message.replace("3 arguments", "three numbers with spaces between them")
        self.exit(2, f"{self.prog}: {message}; see {self.prog} --help.\n")


class ShortHelp(argparse.Action):
    """Prints the help of another parser, and ends."""

    def __init__(self, option_strings: Sequence[str], dest: str, const: Parser, help: str) -> None:
        super().__init__(option_strings, argparse.SUPPRESS, 0, const, argparse.SUPPRESS, help=help)

    def __call__(self, parser: argparse.ArgumentParser, *_: Any) -> NoReturn:
        self.const.print_help()
        parser.exit()
