"""The page in a browser: silent, asking for nothing, drawn, and usable by everyone."""

import shutil
from dataclasses import replace

import numpy as np
import pytest

from bench.records.embedded_pictures import pictures
from bench.records.records import write_record
from bench.report.write import write_report

CHROMIUM = shutil.which("chromium")
pytestmark = pytest.mark.skipif(CHROMIUM is None, reason="chromium is not installed")

PHONE, DESK = {"width": 390, "height": 844}, {"width": 1280, "height": 900}


@pytest.fixture(scope="module")
def html(record, tmp_path_factory):
    """Two records: one with figures, and one with pictures alone."""
    place = tmp_path_factory.mktemp("page")
    shades = {name: np.full((40, 60, 3), shade, np.uint8) for name, shade in SHADES.items()}
    note = pictures("view", ("Pictures", "Three shades.", "A grey field"), shades)
    shown = replace(record, experiment="other", points=(), notes={"pictures": [note]})
    for each in (record, shown):
        write_record(each, place)
    return write_report(place)[0]


SHADES = {"whole": 200, "pruned": 120, "FLIP": 30}


@pytest.fixture(scope="module")
def browser():
    from playwright.sync_api import sync_playwright

    with sync_playwright() as playwright:
        browser = playwright.chromium.launch(executable_path=CHROMIUM, args=["--no-sandbox"])
        yield browser
        browser.close()


@pytest.fixture(params=[PHONE, DESK], ids=["phone", "desk"])
def page(browser, html, request):
    """The opened page; what it complains of or asks for fails the test."""
    page, wrong = browser.new_page(viewport=request.param), []
    page.on("console", lambda message: wrong.append(message.text))
    page.on("pageerror", lambda error: wrong.append(str(error)))
    page.on("request", lambda asked: asked_for(asked.url, html, wrong))
    page.goto(html.as_uri())
    yield page
    page.close()
    assert wrong == []


def asked_for(url, html, wrong):
    if url != html.as_uri() and not url.startswith(("data:", "blob:")):
        wrong.append(url)


def drawn(page):
    """Every plot, scrolled to and drawn."""
    figures = page.locator("figure.interactive")
    for number in range(figures.count()):
        figures.nth(number).scroll_into_view_if_needed()
        figures.nth(number).locator(".plot .main-svg").first.wait_for()
    return figures


def test_plots_are_drawn_and_tell_their_points(page):
    figures = drawn(page)
    assert figures.count() >= 6 and page.locator("figure.interactive:not(.drawn)").count() == 0
    assert page.locator("figure.drawn > svg:visible").count() == 0
    first = figures.first
    first.scroll_into_view_if_needed()
    first.locator(".scatterlayer .points path").first.hover(force=True)
    first.locator(".hoverlayer .hovertext").first.wait_for()
    assert page.evaluate("document.documentElement.scrollWidth - innerWidth") <= 0


def test_a_plot_alone_in_its_row_is_drawn_whole(page):
    """Legend and axes' names are within the frame, on a screen with room for one wide plot."""
    page.set_viewport_size({"width": 720, "height": 900})
    plot = drawn(page).first.locator(".plot")
    frame, svg = plot.bounding_box(), plot.locator(".main-svg").first.bounding_box()
    assert frame["width"] > 600
    assert svg["width"] == pytest.approx(frame["width"], abs=1)
    assert svg["height"] == pytest.approx(frame["height"], abs=1)


def test_plots_are_walked_by_keyboard(page):
    drawn(page)
    plot = page.locator(".plot").first
    plot.focus()
    seen = []
    for key in ("ArrowRight", "ArrowRight", "ArrowDown"):
        plot.press(key)
        plot.locator(".hoverlayer .hovertext").first.wait_for()
        seen.append(page.locator("#told").inner_text())
    assert len(set(seen)) == 3 and all(" at " in text for text in seen)
    plot.press("Escape")
    page.wait_for_function("!document.querySelector('.hoverlayer .hovertext')")


def test_the_slider_divides_two_chosen_pictures(page):
    figure = page.locator("figure.pictures")
    slider, over = figure.locator("input[type=range]"), figure.locator("img").nth(1)
    slider.focus()
    for _ in range(10):
        slider.press("ArrowRight")
    assert "inset(0px 40% 0px 0px)" in over.evaluate("e => getComputedStyle(e).clipPath")
    before = over.get_attribute("src")
    figure.locator("select").first.select_option("FLIP")
    assert over.get_attribute("src") != before
    assert over.get_attribute("alt") == "FLIP. A grey field"


def test_nothing_keeps_anyone_out(page):
    from axe_playwright_python.sync_playwright import Axe

    drawn(page)
    found = Axe().run(page).response["violations"]
    serious = [v for v in found if v["impact"] in ("serious", "critical")]
    assert [(v["id"], v["nodes"][0]["html"][:120]) for v in serious] == []


def test_without_scripts_the_still_figures_stay(browser, html):
    with browser.new_context(java_script_enabled=False) as context:
        page = context.new_page()
        page.goto(html.as_uri())
        assert page.locator("figure > svg:visible").count() >= 6
        assert page.locator(".plot:visible").count() == 0
