"""Makes the pictures of the page for docs/app.md: a lesion of the synthetic patient is treated in a real browser.

usage: make_page_pictures.py [FOLDER]          default: docs/images

Needs the extra `app`, playwright and a Chromium (or its path in the variable CHROMIUM).
"""

import sys
import tempfile
from pathlib import Path

from playwright.sync_api import sync_playwright

PROJECT = Path(__file__).resolve().parents[2]
sys.path[:0] = [str(PROJECT), str(PROJECT / "tests")]

from app_server import CHROMIUM, QUIET, AppServer  # noqa: E402

PICTURES = {
    "app.png": (1280, 800, "light"),
    "app-dark.png": (1280, 800, "dark"),
    "app-tablet.png": (820, 1180, "light"),
    "app-phone.png": (390, 844, "dark"),
}
"""Width and height of the window, and the look that the browser asks for."""
PATIENCE_MS = 600_000
DRAWN_MS = 1000
"""A view that rests is drawn sharply, and a page that is swiped to comes to rest."""


def take(page, path):
    """Choose the lesion, take what is suggested, let it be deployed, and keep what is seen then."""

    def named(name):
        return page.locator(f'[data-name="{name}"]')

    named("lesionTable").filter(has_text="%").wait_for()
    named("lesionTable").locator("tbody td").first.click()
    named("suggestButton").click()
    named("stentTable").locator("tbody tr").first.wait_for()
    named("deployButton").click()
    named("atHand").filter(has_text="certified").wait_for()
    page.evaluate("document.querySelector('.panel').scrollTop = 0; scrollTo(0, 0)")
    page.wait_for_timeout(DRAWN_MS)
    page.screenshot(path=path)


def main(folder):
    """One page of its own for each picture."""
    with tempfile.TemporaryDirectory() as workshop, sync_playwright() as driver:
        server = AppServer(Path(workshop), "--demo")
        browser = driver.chromium.launch(executable_path=CHROMIUM, args=QUIET)
        for name, (width, height, look) in PICTURES.items():
            context = browser.new_context(
                viewport={"width": width, "height": height}, color_scheme=look
            )
            context.set_default_timeout(PATIENCE_MS)
            page = context.new_page()
            page.goto(server.address)
            take(page, folder / name)
            context.close()
        browser.close()
        server.close()


if __name__ == "__main__":
    main(Path(sys.argv[1]) if len(sys.argv) > 1 else PROJECT / "docs" / "images")
