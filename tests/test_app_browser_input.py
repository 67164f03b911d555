"""What a browser says of the view: no size and no event, however wrong, harms a page."""

import math

import numpy as np
import pytest

pytest.importorskip("trame_rca", reason="the extra app is not installed")

from SDFStentApp.browser_input import BrowserInput, known_event

MOUSE = {
    "type": "LeftButtonPress", "action": "down", "w": 850, "h": 464, "x": 200.5, "y": 264,
    "buttonLeft": 1, "shiftKey": 0, "altKey": False, "ctrlKey": 1, "metaKey": 0, "pokedRenderer": 1,
}  # fmt: skip
FINGERS = {
    "type": "Pinch", "factor": 1.25,
    "positions": {"4": {"x": 260, "y": 264, "z": 0}, "5": {"x": 1, "y": 2}},
}  # fmt: skip
NONSENSE = [math.nan, math.inf, -math.inf, 1e9, -1e300, 10**400, "a", None, [1], {}, {"x": 1}, b"x"]


class Area:
    """Remembers what reaches VTK."""

    def __init__(self):
        self.sizes, self.events = [], []

    def process_resize_event(self, *size):
        self.sizes.append(size)

    def process_interaction_event(self, event):
        self.events.append(event)


class Scheduler:
    def set_push_callback(self, push):
        """As a scheduler has it."""

    def schedule_render(self):
        """As a scheduler has it."""


@pytest.fixture
def an_input():
    scheduler = Scheduler()
    scheduler.rca = Area()
    return BrowserInput(scheduler.rca, "view", scheduler=scheduler)


def test_a_hands_events_reach_the_view_with_what_is_known_of_them():
    unknown = {"action", "buttonLeft", "pokedRenderer"}
    assert known_event(MOUSE) == {name: MOUSE[name] for name in MOUSE if name not in unknown}
    assert known_event(FINGERS) == FINGERS
    assert known_event({"type": "KeyPress", "key": "a", "keyCode": 97, "firstRenderer": None}) == {
        "type": "KeyPress", "key": "a", "keyCode": 97,
    }  # fmt: skip
    assert known_event({"type": "Pan", "translation": [3, -4.5]}) is not None
    assert known_event({"type": "LongTap", "w": 820, "h": 365}) is None  # VTK complains of it


@pytest.mark.parametrize("wrong", NONSENSE, ids=lambda value: str(value)[:20])
def test_an_event_with_anything_that_cannot_be_is_left_out(wrong):
    for name in ("x", "w", "spinY", "rotation", "keyCode", "factor", "shiftKey", "positions"):
        if not (name == "positions" and wrong == {}):
            assert known_event({**MOUSE, name: wrong}) is None, name
    assert known_event({**FINGERS, "positions": {"4": {"x": wrong, "y": 1}}}) is None
    assert known_event({"type": "Pan", "translation": [wrong, 1]}) is None
    assert known_event(wrong) is None


@pytest.mark.parametrize(
    "event",
    [
        {**FINGERS, "factor": 0},  # two fingers at one place
        {**FINGERS, "factor": math.inf},
        {"type": "KeyPress", "key": "x" * 100_000},
        {"type": 7},
        {"x": 1, "y": 1},
        {"type": "Pan", "translation": [1]},
        {**FINGERS, "positions": {str(number): {"x": 1, "y": 1} for number in range(1000)}},
    ],
)
def test_fingers_at_one_place_and_words_without_end_are_left_out(event):
    assert known_event(event) is None


def test_random_events_never_raise():
    random = np.random.default_rng(20261123)
    values = [*NONSENSE, 0, 1, 5.5, True, "LeftButtonPress", [1, 2], {"4": {"x": 1, "y": 1}}]
    names = ["type", "x", "y", "factor", "positions", "translation", "key", "shiftKey", "other"]
    for _ in range(2000):
        chosen = random.choice(len(names), 4)
        event = {names[i]: values[random.integers(len(values))] for i in chosen}
        known = known_event(event)
        assert known is None or set(known) <= set(event)


@pytest.mark.parametrize(
    "wrong", [value for value in NONSENSE if value is not None], ids=lambda value: str(value)[:20]
)
def test_a_size_that_no_screen_has_leaves_the_one_before(an_input, wrong):
    an_input.update_size("me", {"w": 800, "h": 600, "p": 1})
    for name in ("w", "h", "p"):
        an_input.update_size("me", {"w": 80, "h": 60, "p": 1, name: wrong})
    an_input.update_size("me", wrong)
    an_input.update_size("me", {"w": 80, "h": 60, "p": 0})
    an_input.update_size("me", None)
    assert an_input.image_size == (800, 600)
    assert set(an_input._rca.sizes) == {(800, 600)}
