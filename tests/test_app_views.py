"""Working view and X-ray in the page, without a browser: what its process draws and tells."""

import json
from importlib.util import find_spec

import pytest
from child_processes import python

needed = all(map(find_spec, ("slicer", "trame", "trame_rca", "aiohttp")))
pytestmark = pytest.mark.skipif(not needed, reason="the extra app is not installed")

SCRIPT = """
import asyncio, json, sys
import numpy as np
from SDFStentApp import process
process.prepare()
from trame.app import get_server
from SDFStentApp.page import Page, Plain

async def visited():
    server = get_server("sdfstent", client_type="vue3", translator=Plain())
    opening = {"demo": True, "plan": None, "surface": None, "centerline": None, "units": "mm"}
    page = Page(server, {**opening, "folders": [], "module": process.MODULE})
    page.build()
    page.open_named()
    panel, widget = page.panel, page.widget

    async def rest():
        await asyncio.sleep(0.1)
        busy = lambda: any(
            one.isBusy for one in (widget.session, widget.lesions, widget.sight, widget.recoil)
        )
        while busy():
            await asyncio.sleep(0.02)
        await asyncio.sleep(0.3)

    def seen():
        page.view.window.SetSize(200, 200)
        page.view.window.Render()
        return page.view.picture()[0]

    await rest()
    panel.viewsCollapsibleButton.edit(False)
    page.click("addStentButton")
    await rest()
    page.click("workingViewButton")
    await rest()
    told = {"best": server.state.atHand["angles"], "lao": panel.laoSpinBox.value}
    panel.laoSpinBox.edit(35.0)
    panel.craSpinBox.edit(-15.0)
    await rest()
    told["typed"] = server.state.atHand["angles"]
    before = seen()
    panel.xrayCheckBox.edit(True)
    await rest()
    told["x-ray"] = server.state.atHand["angles"]
    told["label"] = server.state.viewLabel["text"]
    film = seen()
    middle = film[60:140, 60:140].astype(int)
    told["is gray"] = bool((np.ptp(middle, axis=2) < 12).mean() > 0.9)
    told["was gray"] = bool((np.ptp(before[60:140, 60:140].astype(int), axis=2) < 12).mean() > 0.5)
    told["is dark and light"] = [int(film.min()), int(film.max())]
    page.view.look_from("Left")
    await asyncio.sleep(0.2)
    told["at once"] = server.state.atHand["angles"]
    print(json.dumps(told))

asyncio.run(visited())
sys.stdout.flush()
import os; os._exit(0)
"""


def test_the_page_turns_its_view_as_a_c_arm_and_shows_the_x_ray():
    done = python(SCRIPT)
    told = json.loads(done.stdout.splitlines()[-1])
    assert told["best"][0].startswith(("LAO", "RAO"))
    assert told["best"][1].startswith("foreshortened ")
    assert told["typed"][0] == "LAO 35, CAU 15"
    assert told["x-ray"][-1].startswith("X-ray, bar ")
    assert told["label"].startswith("View LAO 35, CAU 15: foreshortened ")
    assert (told["was gray"], told["is gray"]) == (False, True)
    assert told["is dark and light"][1] > 250
    assert told["at once"][0] == "LAO 90, CRA 0"
