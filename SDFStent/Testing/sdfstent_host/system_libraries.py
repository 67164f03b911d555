"""The system libraries that Qt and off-screen rendering need, and the Debian package that contains each."""

import ctypes
import sys
from pathlib import Path

PACKAGE_OF_LIBRARY = {
    "libEGL.so.1": "libegl1",
    "libGL.so.1": "libgl1",
    "libX11.so.6": "libx11-6",
    "libxkbcommon.so.0": "libxkbcommon0",
    "libdbus-1.so.3": "libdbus-1-3",
    "libglib-2.0.so.0": "libglib2.0-0",
    "libfontconfig.so.1": "libfontconfig1",
    "libfreetype.so.6": "libfreetype6",
    "libEGL_mesa.so.0": "libegl-mesa0",
}
FONT_FOLDERS = (Path("/usr/share/fonts"), Path("/usr/local/share/fonts"), Path.home() / ".fonts")
FONT_PACKAGE = "fonts-dejavu-core"


def missingLibraries():
    """A sentence for each missing library or font; none on a machine that can run the host."""
    if not sys.platform.startswith("linux"):
        return []
    missing = [
        f"{library} is missing: install the Debian package {package}."
        for library, package in PACKAGE_OF_LIBRARY.items()
        if not _canLoad(library)
    ]
    if not any(next(folder.rglob("*.ttf"), None) for folder in FONT_FOLDERS if folder.is_dir()):
        missing.append(
            f"No TrueType font was found, text would be empty boxes: install the Debian package {FONT_PACKAGE}."
        )
    return missing


def debianPackages():
    """All Debian packages that `missingLibraries` may ask for."""
    return sorted({*PACKAGE_OF_LIBRARY.values(), FONT_PACKAGE})


def _canLoad(library):
    try:
        ctypes.CDLL(library)
    except OSError:
        return False
    return True


if __name__ == "__main__":
    print("\n".join(missingLibraries()) or " ".join(debianPackages()))
    sys.exit(bool(missingLibraries()))
