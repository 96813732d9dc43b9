"""The page in a browser: silent, asking for nothing, drawn, and usable by everyone."""

import re
from dataclasses import replace

import numpy as np
import pytest

from bench.records.records import pictures, write_record
from bench.report.write import write_report

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


def hovered(page, plot, number):
    """What a plot says of one of its points, under the pointer."""
    plot.scroll_into_view_if_needed()
    box = plot.locator(".mark").nth(number).bounding_box()
    page.mouse.move(box["x"] + box["width"] / 2, box["y"] + box["height"] / 2)
    return plot.locator(".tip")


def test_plots_tell_their_points(page):
    plots = page.locator("main figure.plot .panel")
    assert plots.count() >= 3
    for number in (0, 1):
        tip = hovered(page, plots.first, number)
        assert re.fullmatch(r"people: [\d.]+ \([\d.]+ to [\d.]+\) at [\d.]+", tip.inner_text())
        frame, said = plots.first.bounding_box(), tip.bounding_box()
        assert frame["x"] <= said["x"]
        assert said["x"] + said["width"] <= frame["x"] + frame["width"] + 1
    page.mouse.move(0, 0)
    assert tip.is_hidden() and plots.first.locator(".mark.told").count() == 0
    assert page.evaluate("document.documentElement.scrollWidth - innerWidth") <= 0


def test_a_plot_can_be_enlarged(page):
    page.set_viewport_size({"width": 1280, "height": 900})
    svg = page.locator("main .panel svg").first
    before = svg.bounding_box()["width"]
    svg.click()
    assert svg.bounding_box()["width"] > 1.5 * before
    svg.press("Enter")
    assert svg.bounding_box()["width"] == before


def test_plots_are_walked_by_keyboard(page):
    plot = page.locator("main .panel").first
    svg, seen = plot.locator("svg"), []
    svg.focus()
    for key in ("ArrowRight", "ArrowRight"):
        svg.press(key)
        seen.append(page.locator("#told").inner_text())
        assert plot.locator(".tip").inner_text() == seen[-1]
    assert len(set(seen)) == 2 and all(" at " in text for text in seen)
    svg.press("Escape")
    assert plot.locator(".tip").is_hidden()


def test_the_slider_divides_two_chosen_pictures(page):
    figure = page.locator("main figure.pictures")
    slider, over = figure.locator("input[type=range]"), figure.locator("img.over")
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

    found = Axe().run(page).response["violations"]
    serious = [v for v in found if v["impact"] in ("serious", "critical")]
    assert [(v["id"], v["nodes"][0]["html"][:120]) for v in serious] == []


def test_without_scripts_the_still_figures_stay(browser, html):
    with browser.new_context(java_script_enabled=False) as context:
        page = context.new_page()
        page.goto(html.as_uri())
        assert page.locator(".panel svg:visible").count() >= 4
        title = page.locator(
            "main .mark title"
        ).first  # the browser itself shows it under the pointer
        assert re.fullmatch(r"people: [\d.]+ \([\d.]+ to [\d.]+\) at [\d.]+", title.text_content())
