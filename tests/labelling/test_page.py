"""The labelling page in a real browser: drawn with the mouse, killed, started again, saved."""

import os
import shutil
import signal

import numpy as np
import pytest

from active_perceiver.labelling.view_labels import labels_of
from active_perceiver.scenes import load_scene
from active_perceiver.scenes.scene import LABELLED, PROPOSED

CHROMIUM = next(filter(None, map(shutil.which, ("chromium", "chromium-browser", "google-chrome"))), None)
if CHROMIUM is None:
    pytest.skip("there is no Chromium on this machine (Debian: apt-get install chromium)", allow_module_level=True)
playwright = pytest.importorskip("playwright.sync_api", reason="playwright is in the extra `dev`")
expect = playwright.expect
expect.set_options(timeout=20_000)  # for busy machines

FIRST_PROPOSED, FIRST_UNLABELLED = 16, 32
PIXEL = 1 / 64


@pytest.fixture(scope="module")
def browser():
    # Chromium's sandbox does not work for root, who runs tests in containers.
    arguments = ["--no-sandbox"] if os.geteuid() == 0 else []
    with playwright.sync_playwright() as running:
        browser = running.chromium.launch(executable_path=CHROMIUM, args=arguments)
        yield browser
        browser.close()


class Page:
    """The page as a person uses it."""

    def __init__(self, browser, url):
        self.page = browser.new_page(viewport={"width": 1280, "height": 800})
        self.errors = []
        self.page.on("pageerror", lambda error: self.errors.append(str(error)))
        self.open(url)

    def open(self, url):
        self.page.goto(url)
        self.page.wait_for_selector("body[data-ready]")

    def press(self, *keys):
        for key in keys:
            self.page.keyboard.press(key)

    def at(self, x, y):
        """A place in the view, given as fractions of it, in pixels of the screen."""
        frame = self.page.locator("#canvas").bounding_box()
        return frame["x"] + x * frame["width"], frame["y"] + y * frame["height"]

    def drag(self, start, end):
        mouse = self.page.mouse
        mouse.move(*self.at(*start))
        mouse.down()
        mouse.move(*self.at(*((a + b) / 2 for a, b in zip(start, end, strict=True))))
        mouse.move(*self.at(*end))
        mouse.up()

    def click(self, x, y):
        self.page.mouse.click(*self.at(x, y))

    def box(self, target):
        return self.page.locator(f"#boxes .box[data-target={target}]")

    def corners(self, target):
        """Left, top, right and bottom of a box as it is shown, as fractions of the view."""
        frame, box = self.page.locator("#canvas").bounding_box(), self.box(target).bounding_box()
        left, top = ((box[k] - frame[k]) / frame["width"] for k in "xy")
        return np.array([left, top, left + box["width"] / frame["width"], top + box["height"] / frame["height"]])

    def shows(self, view, state):
        expect(self.page.locator("#view-title")).to_have_text(f"View {view + 1} of 48")
        expect(self.page.locator("#state")).to_have_text(state)

    def is_kept(self, kept="yes"):
        expect(self.page.locator(f"#kept[data-kept={kept}]")).to_have_count(1, timeout=30_000)

    def note(self):
        return self.page.locator("#note")


@pytest.fixture
def opened(browser, room, start):
    """A running server and the page open."""
    server = start(room, "--port", "0")
    page = Page(browser, server.url)
    yield server, page
    assert page.errors == []
    page.page.close()


def corners_of(box):
    return np.array([box[0] - box[2] / 2, box[1] - box[3] / 2, box[0] + box[2] / 2, box[1] + box[3] / 2])


def saved_corners(room, view, target):
    return corners_of(labels_of(load_scene(room))[view].boxes[target])


def test_a_session_from_the_first_box_to_the_saved_scene(opened, room, start, partly):
    server, page = opened
    # Draw, undo, redo.
    page.press("u")
    page.shows(FIRST_UNLABELLED, "not labelled yet")
    page.press("2")
    page.drag((0.2, 0.3), (0.6, 0.75))
    page.shows(FIRST_UNLABELLED, "labelled: 1 box")
    np.testing.assert_allclose(page.corners("ball1"), [0.2, 0.3, 0.6, 0.75], atol=PIXEL / 4)
    page.press("Control+z")
    expect(page.box("ball1")).to_have_count(0)
    page.shows(FIRST_UNLABELLED, "not labelled yet")
    page.press("Control+Shift+Z")
    page.shows(FIRST_UNLABELLED, "labelled: 1 box")

    # Accept what was proposed; undone from another view it is shown.
    page.press("p")
    expect(page.page.locator("#state")).to_have_attribute("data-label", "proposed")
    accepted = int(page.page.locator("#view-title").inner_text().split()[1]) - 1
    assert partly.labels[accepted] == PROPOSED
    page.press("a")
    expect(page.page.locator("#state")).to_have_attribute("data-label", "labelled")
    page.press("u")
    page.shows(FIRST_UNLABELLED + 1, "not labelled yet")
    page.press("z")
    expect(page.page.locator("#state")).to_have_attribute("data-label", "proposed")
    page.press("y")
    expect(page.page.locator("#state")).to_have_attribute("data-label", "labelled")

    # After a reload all is there, and can still be undone.
    page.is_kept()
    page.press("u")
    page.page.reload()
    page.page.wait_for_selector("body[data-ready]")
    page.shows(FIRST_UNLABELLED + 1, "not labelled yet")
    expect(page.page.locator("#counts")).to_contain_text("18 labelled")
    page.press("z", "z", "y", "y", "u", "ArrowLeft")
    page.shows(FIRST_UNLABELLED, "labelled: 1 box")
    page.is_kept()

    # The server dies; what is drawn then is kept by the page until another one answers.
    server.end(signal.SIGKILL)
    page.press("ArrowRight", "1")
    page.drag((0.8, 0.9), (0.5, 0.4))
    page.is_kept("no")
    expect(page.page.locator("#kept")).to_contain_text("not kept: the server does not answer")
    again = start(room, "--port", str(server.port))
    assert "left in its journal: 2" in again.said
    page.is_kept()
    np.testing.assert_allclose(saved_corners(room, FIRST_UNLABELLED, "ball1"), [0.2, 0.3, 0.6, 0.75], atol=PIXEL)

    # Save, end, and look into the file.
    expect(page.page.locator("#save")).to_have_text("Save (1 view)")
    page.page.locator("#save").click()
    expect(page.note()).to_have_text("saved: 1 changed view")
    expect(page.page.locator("#save")).to_be_disabled()
    again.end(signal.SIGINT)
    saved = load_scene(room)
    np.testing.assert_allclose(saved_corners(room, FIRST_UNLABELLED, "ball1"), [0.2, 0.3, 0.6, 0.75], atol=PIXEL)
    np.testing.assert_allclose(saved_corners(room, FIRST_UNLABELLED + 1, "ball0"), [0.5, 0.4, 0.8, 0.9], atol=PIXEL)
    changed = [accepted, FIRST_UNLABELLED, FIRST_UNLABELLED + 1]
    assert (saved.labels[changed] == LABELLED).all()
    others = np.delete(np.arange(48), changed)
    np.testing.assert_array_equal(saved.labels[others], partly.labels[others])
    np.testing.assert_array_equal(saved.boxes[others], partly.boxes[others])
    np.testing.assert_array_equal(saved.boxes[accepted], partly.boxes[accepted])


def test_boxes_are_moved_resized_chosen_and_deleted(opened):
    _, page = opened
    page.press("u")
    page.drag((0.2, 0.2), (0.6, 0.6))  # the first target is chosen at first
    page.drag((0.4, 0.4), (0.9, 0.2))  # from its middle: moved, and stopped by the edge of the view
    np.testing.assert_allclose(page.corners("ball0"), [0.6, 0.0, 1.0, 0.4], atol=PIXEL / 4)
    page.drag((0.6, 0.4), (0.3, 0.7))  # its corner
    np.testing.assert_allclose(page.corners("ball0"), [0.3, 0.0, 1.0, 0.7], atol=PIXEL / 4)
    page.drag((0.3, 0.35), (0.5, 0.9))  # its edge goes one way only
    np.testing.assert_allclose(page.corners("ball0"), [0.5, 0.0, 1.0, 0.7], atol=PIXEL / 4)
    page.press("3")
    page.drag((0.7, 0.2), (0.8, 0.3))  # another target within it
    page.shows(FIRST_UNLABELLED, "labelled: 2 boxes")
    page.click(0.55, 0.5)
    expect(page.page.locator("#targets .chosen")).to_have_attribute("data-target", "ball0")
    page.click(0.75, 0.25)  # in the chosen one: nothing happens
    page.press("2")
    page.click(0.75, 0.25)  # the smaller of two
    expect(page.page.locator("#targets .chosen")).to_have_attribute("data-target", "ball2")
    page.press("Delete")
    expect(page.box("ball2")).to_have_count(0)
    page.press("1", "Backspace")
    page.shows(FIRST_UNLABELLED, "labelled: nothing here")
    page.drag((0.5, 0.5), (0.501, 0.501))  # too small to be meant
    page.shows(FIRST_UNLABELLED, "labelled: nothing here")
    page.is_kept()


def test_views_without_anything_copies_and_what_is_left(opened, partly):
    _, page = opened
    page.press("u", "n")
    page.shows(FIRST_UNLABELLED, "labelled: nothing here")
    page.press("Enter")
    page.shows(FIRST_UNLABELLED + 1, "not labelled yet")
    page.press("1", "c")
    page.shows(FIRST_UNLABELLED + 1, "labelled: 1 box")
    shown = page.corners("ball0")
    boxes = [corners_of(box) for box in partly.boxes[:FIRST_UNLABELLED, 0] if not np.isnan(box[0])]
    assert min(abs(shown - box).max() for box in boxes) < PIXEL / 4
    page.press("ArrowLeft", "ArrowLeft")
    page.press("Enter")  # right as proposed; the next that is not labelled is after the labelled ones
    expect(page.page.locator("#state")).not_to_have_attribute("data-label", "labelled")
    for _ in range(60):
        page.press("Enter")
    expect(page.note()).to_have_text("every view is labelled")
    expect(page.page.locator("#counts")).to_contain_text("48 labelled")
    page.is_kept()


def test_two_pages_do_not_undo_each_other(browser, opened):
    server, page = opened
    other = Page(browser, server.url)
    for one in (page, other):
        one.press("u")
    page.drag((0.1, 0.1), (0.3, 0.3))
    page.is_kept()
    other.drag((0.5, 0.5), (0.7, 0.7))
    expect(other.note()).to_contain_text("changed by another page")
    np.testing.assert_allclose(other.corners("ball0"), [0.1, 0.1, 0.3, 0.3], atol=PIXEL / 4)
    other.press("z")  # what it drew is not there any more
    expect(other.note()).to_have_text("there is nothing to undo")
    assert other.errors == []
    other.page.close()


def test_everything_fits_on_a_small_screen(opened):
    _, page = opened
    page.press("p")
    size = page.page.evaluate("[document.documentElement.scrollWidth, document.documentElement.scrollHeight]")
    assert size == [1280, 800]
    for name in ("#save", "#canvas", "[data-do=proposed]", "#strip", "#help dl dd:last-child", "#pictures img"):
        frame = page.page.locator(name).last.bounding_box()
        assert 0 <= frame["x"] < frame["x"] + frame["width"] <= 1280 or name == "#strip"
        assert 0 <= frame["y"] < frame["y"] + frame["height"] <= 800
    canvas = page.page.locator("#canvas").bounding_box()
    assert canvas["width"] == canvas["height"] > 500
    assert page.page.evaluate("document.querySelector('#view').naturalWidth") == 64
