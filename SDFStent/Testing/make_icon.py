"""Draw the extension's icon: a narrowed vessel that a stent holds open. Writes the SVG and the 128 px PNG.

usage: make_icon.py
"""

import math
import os
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]
SVG = ROOT / "SDFStent" / "Resources" / "Icons" / "SDFStent.svg"
PNG = ROOT / "SDFStent.png"
SIZE = 128


def wall(x):
    """Half width of the vessel at `x`: narrow in the upper left, opened to the stent's width in the middle."""
    narrowing = 17 * math.exp(-(((x - 18) / 13) ** 2))
    return 33 - narrowing


def vesselPath():
    xs = range(0, SIZE + 1, 2)
    upper = [(x, 64 - wall(x)) for x in xs]
    lower = [(x, 64 + wall(x)) for x in reversed(xs)]
    return "M" + " L".join(f"{x:.1f},{y:.1f}" for x, y in upper + lower) + " Z"


def stentPaths(start=40, end=118, rows=4, columns=6, half=29):
    """Diamond cells: zigzag rings, each the mirror of its neighbour, foreshortened towards the vessel's rim."""
    heights = [64 + half * math.sin(math.pi * (i / rows - 0.5)) for i in range(rows + 1)]
    width = (end - start) / columns
    for column in range(columns + 1):
        x = start + column * width
        for shift in (-1, 1):
            points = [(x + shift * width / 2 * (i % 2), y) for i, y in enumerate(heights)]
            if all(start <= p[0] <= end for p in points):
                yield "M" + " L".join(f"{a:.1f},{b:.1f}" for a, b in points)


def svg():
    stent = "\n".join(f'  <path d="{path}"/>' for path in stentPaths())
    return f"""<svg xmlns="http://www.w3.org/2000/svg" width="{SIZE}" height="{SIZE}" viewBox="0 0 {SIZE} {SIZE}">
 <defs>
  <linearGradient id="wall" x1="0" y1="0" x2="0" y2="1">
   <stop offset="0.22" stop-color="#8e1b1f"/>
   <stop offset="0.45" stop-color="#e8655a"/>
   <stop offset="0.78" stop-color="#7a1418"/>
  </linearGradient>
 </defs>
 <path d="{vesselPath()}" fill="url(#wall)" stroke="#5a0d11" stroke-width="3"/>
 <g fill="none" stroke="#f4f7fa" stroke-width="3.4" stroke-linejoin="round" stroke-linecap="round">
{stent}
 </g>
</svg>
"""


def main():
    os.environ.setdefault("QT_QPA_PLATFORM", "offscreen")
    from PySide6 import QtCore, QtGui, QtSvg

    SVG.write_text(svg(), encoding="utf-8")
    application = QtGui.QGuiApplication([])
    image = QtGui.QImage(SIZE, SIZE, QtGui.QImage.Format_ARGB32)
    image.fill(QtCore.Qt.transparent)
    painter = QtGui.QPainter(image)
    QtSvg.QSvgRenderer(str(SVG)).render(painter)
    painter.end()
    image.save(str(PNG))
    del application


if __name__ == "__main__":
    main()
