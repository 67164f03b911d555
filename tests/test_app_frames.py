"""When frames are drawn: coarse while something moves, one at a time, then a sharp one."""

import asyncio

import numpy as np
import pytest
from child_processes import PATIENCE

pytest.importorskip("trame_rca", reason="the extra app is not installed")

from SDFStentApp.frames import MOVING_QUALITY, STILL_QUALITY, FrameScheduler

SIZE = (40, 30)


class Painted:
    """Remembers how it was drawn; `fails` is how often it cannot be."""

    def __init__(self, fails=0):
        self.drawn, self.fails = [], fails

    def picture(self, isCoarse):
        self.drawn.append(isCoarse)
        if len(self.drawn) <= self.fails:
            raise RuntimeError("no window")
        return np.zeros((SIZE[1], SIZE[0], 3), np.uint8), *SIZE


def sent(painted, during=None):
    """What is sent until a frame is sharp; `during(frames, sent)` is called with every one."""

    async def watch():
        frames, found, isOver = FrameScheduler(painted), [], asyncio.Event()

        def push(content, about):
            assert content.startswith(b"\xff\xd8")
            found.append(about["quality"])
            assert frames.isBehind
            if during is not None:
                during(frames, found)
            if about["quality"] == STILL_QUALITY:
                isOver.set()

        frames.set_push_callback(push)
        assert not frames.isBehind
        frames.schedule_render()
        assert frames.isBehind
        await asyncio.wait_for(isOver.wait(), PATIENCE)
        await asyncio.sleep(0)
        assert not frames.isBehind
        await frames.close()
        return found

    return asyncio.run(watch())


def test_a_change_is_drawn_coarsely_and_sharply_once_it_rests():
    painted = Painted()
    assert sent(painted) == [MOVING_QUALITY, STILL_QUALITY]
    assert painted.drawn == [True, False]


def test_changes_while_a_frame_is_on_its_way_are_one_more_frame():
    def change(frames, found):
        if len(found) < 3:
            for _ in range(5):
                frames.schedule_render()

    painted = Painted()
    assert sent(painted, change) == [MOVING_QUALITY] * 3 + [STILL_QUALITY]
    assert len(painted.drawn) == 4


def test_a_frame_that_cannot_be_drawn_is_not_the_last_one(caplog):
    assert sent(Painted(fails=1)) == [STILL_QUALITY]
    assert "no window" in caplog.text


def test_what_is_begun_before_a_frame_goes_on_beside_it():
    async def watch():
        loop, order, isOver = asyncio.get_running_loop(), [], asyncio.Event()
        painted = Painted()
        painted.picture = lambda isCoarse: (
            order.append("drawn"),
            Painted.picture(painted, isCoarse),
        )[1]

        def begin():
            order.append("value taken")
            loop.call_later(0, lambda: loop.call_later(0, order.append, "preview begun"))

        frames = FrameScheduler(painted, begin)
        frames.set_push_callback(lambda *_: isOver.set())
        frames.schedule_render()
        await asyncio.wait_for(isOver.wait(), PATIENCE)
        assert frames.count == 1
        await frames.close()
        return order

    assert asyncio.run(watch()) == ["value taken", "preview begun", "drawn"]


def test_it_is_a_scheduler_as_trame_rca_defines_them():
    from trame_rca.schedulers import RcaRenderSchedulerProtocol

    async def is_one():
        frames = FrameScheduler(Painted())
        isOne = isinstance(frames, RcaRenderSchedulerProtocol)
        await frames.close()
        return isOne

    assert asyncio.run(is_one())
