"""The page in a browser: keyboard alone, silent, resumed, and QUEST+ as questplus has it."""

import json
import math
import re
from contextlib import ExitStack

import numpy as np
import pytest

from bench.observers.plan import FITTED_LEVELS, STAIRCASE
from bench.observers.psychometric import GUESS, chance_correct
from bench.observers.results import read_result


@pytest.fixture
def context(browser, request):
    width, height = getattr(request, "param", (1280, 800))
    with browser.new_context(viewport={"width": width, "height": height}) as context:
        yield context


class Visitor:
    """Somebody with a keyboard before the page; what the page complains of is kept."""

    def __init__(self, context, experiment):
        self.page, self.wrong = context.new_page(), []
        self.page.on("console", lambda message: self.wrong.append(message.text))
        self.page.on("pageerror", lambda error: self.wrong.append(str(error)))
        allowed = ("file:", "blob:", "data:")
        self.page.on(
            "request", lambda r: None if r.url.startswith(allowed) else self.wrong.append(r.url)
        )
        self.page.goto((experiment / "index.html").as_uri())

    def sheet(self, title, keys=""):
        """Wait for a sheet, type into its field and press Enter."""
        self.page.get_by_role("heading", name=title).wait_for()
        for key in keys:
            self.page.keyboard.press(key)
        self.page.keyboard.press("Enter")

    def begin(self, observer):
        self.sheet("What can be seen in pictures")
        self.sheet("Your number", str(observer))

    def set_up(self):
        self.sheet("The size of the screen", ["ArrowRight"] * 3)
        self.sheet("Where you sit")
        self.sheet("Grey", ["ArrowLeft"])
        self.sheet("Black", ["ArrowRight"] * 5)
        self.sheet("What to do")
        for number in range(3):
            self.page.get_by_text(f"Practice {number + 1} of 3").wait_for()
            self.ready()
            self.page.keyboard.press("ArrowRight")
            self.sheet(re.compile("Right|It was the other one"))

    def ready(self):
        asked = self.page.locator(".asked:not(.hidden), .trial:not(.hidden) .row")
        asked.first.wait_for(state="visible", timeout=20000)

    def answer(self, choose):
        """Answer the trial that is shown; `choose` is given it as the page knows it."""
        self.ready()
        trial = self.page.evaluate("protocol.next()")
        done = self.page.evaluate("protocol.done")
        self.page.keyboard.press("ArrowLeft" if choose(trial) == 0 else "ArrowRight")
        self.page.wait_for_function(f"protocol.done > {done}")
        if self.page.evaluate(
            "protocol.done % PLAN.break_every === 0 && protocol.done < protocol.slots.length"
        ):
            self.sheet("A break")
        return trial

    def left(self):
        return self.page.evaluate("protocol.slots.length - protocol.done")

    def saved(self, folder):
        self.page.get_by_role("heading", name="Thank you").wait_for()
        with self.page.expect_download() as download:
            self.page.keyboard.press("Enter")
        path = folder / download.value.suggested_filename
        download.value.save_as(path)
        return path


def test_a_closed_tab_loses_no_answer(context, experiment, plan, tmp_path):
    first = Visitor(context, experiment)
    first.begin(7)
    first.set_up()
    seen = [first.answer(lambda trial: trial["side"]) for _ in range(3)]
    coming = first.page.evaluate("protocol.next()")
    first.page.close()
    second = Visitor(context, experiment)
    second.begin(7)
    second.sheet("Welcome back")
    second.ready()
    assert second.page.evaluate("content.trials.length") == 3
    assert second.page.evaluate("protocol.next()") == coming
    seen.append(second.answer(lambda trial: 1 - trial["side"]))
    kept = second.page.evaluate("content.trials")
    assert [{k: each[k] for k in seen[0]} for each in kept] == seen
    assert first.wrong + second.wrong == []


def test_who_stops_in_a_break_has_a_file(context, experiment, plan, tmp_path):
    visitor = Visitor(context, experiment)
    visitor.page.evaluate("PLAN.break_every = 2")
    visitor.begin(8)
    visitor.set_up()
    for _ in range(2):
        visitor.ready()
        visitor.page.keyboard.press("ArrowLeft")
        visitor.page.wait_for_timeout(100)
    visitor.page.get_by_role("heading", name="A break").wait_for()
    visitor.page.get_by_role("button", name="Stop here").focus()
    visitor.page.keyboard.press("Enter")
    session = read_result(visitor.saved(tmp_path), plan)
    assert len(session.trials) == 2 and session.excluded(plan) == "the session was not finished"
    assert visitor.wrong == []


@pytest.mark.parametrize("context", [(1280, 800), (3840, 2160)], indirect=True)
def test_nothing_keeps_anyone_out(context, experiment):
    from axe_playwright_python.sync_playwright import Axe

    visitor = Visitor(context, experiment)
    titles = ("What can be seen in pictures", "Your number", "The size of the screen")
    for title in (*titles, "Where you sit", "Grey", "Black", "What to do"):
        visitor.page.get_by_role("heading", name=title).wait_for()
        assert visitor.page.evaluate("document.documentElement.scrollWidth - innerWidth") <= 0
        found = Axe().run(visitor.page).response["violations"]
        serious = [v["id"] for v in found if v["impact"] in ("serious", "critical")]
        assert (title, serious) == (title, [])
        visitor.sheet(title, "9" if title == "Your number" else "")
    visitor.ready()
    found = Axe().run(visitor.page).response["violations"]
    assert [v["id"] for v in found if v["impact"] in ("serious", "critical")] == []


@pytest.mark.parametrize("said", ["0", "1.5"])
def test_a_number_that_is_none_is_refused(context, experiment, said):
    visitor = Visitor(context, experiment)
    visitor.begin(said)
    assert "whole number" in visitor.page.get_by_role("alert").inner_text() or (
        visitor.page.evaluate("!document.querySelector('input').validity.valid")
    )


def simulated_answers(rng):
    log75, slope, lapse = 0.4, 2.5, 0.02
    alpha = log75 - math.log10(math.log(2)) / slope
    chance = chance_correct(np.array(FITTED_LEVELS), *np.array([alpha, slope, lapse])[:, None])
    return lambda trial: (
        trial["side"] if rng.random() < chance[trial["level"]] else 1 - trial["side"]
    )


@pytest.mark.slow
def test_simulated_observers_finish_the_page(browser, experiment, plan, tmp_path):
    """Three at once, as each waits for its clips most of the time; pauses are a tenth as long."""
    faster = "const later = setTimeout; setTimeout = (then, ms) => later(then, ms / 10);"
    with ExitStack() as stack:
        going = {}
        for observer in (1, 2, 3):
            context = browser.new_context(viewport={"width": 1280, "height": 800})
            stack.enter_context(context).add_init_script(faster)
            visitor = going[observer] = Visitor(context, experiment)
            visitor.begin(observer)
            visitor.set_up()
        choices = {each: simulated_answers(np.random.default_rng(each)) for each in going}
        while any(visitor.left() for visitor in going.values()):
            for observer, visitor in going.items():
                if visitor.left():
                    visitor.answer(choices[observer])
        for observer, visitor in going.items():
            path = visitor.saved(tmp_path)
            session = read_result(path, plan)
            assert len(session.trials) == plan["block_trials"] and session.observer == observer
            assert json.loads(path.read_text("utf-8"))["content"]["finished"]
            assert visitor.wrong == []


def test_the_staircase_is_that_of_questplus(browser, experiment):
    questplus = pytest.importorskip("questplus")
    page = browser.new_page()
    page.goto((experiment / "index.html").as_uri())
    rng = np.random.default_rng(48)
    answers = (rng.random((6, 40)) < 0.8).tolist()
    ours = page.evaluate(
        """(all) => all.map((answers) => {
            const quest = new Quest(PLAN.staircase);
            return answers.map((correct) => {
                const level = quest.next();
                quest.update(level, correct);
                return level;
            });
        })""",
        answers,
    )
    page.close()
    levels = list(STAIRCASE.levels)
    for row, told in zip(answers, ours, strict=True):
        theirs = questplus.QuestPlusWeibull(
            intensities=levels,
            thresholds=list(STAIRCASE.thresholds),
            slopes=list(STAIRCASE.slopes),
            lower_asymptotes=[GUESS],
            lapse_rates=list(STAIRCASE.lapses),
            responses=["right", "wrong"],
            stim_scale="log10",
        )
        posterior = STAIRCASE.start(1)
        for correct, level in zip(row, told, strict=True):
            intensity = theirs.next_intensity
            assert levels[level] == intensity
            assert STAIRCASE.next_level(posterior)[0] == level
            at, right = np.array([level]), np.array([correct])
            posterior = STAIRCASE.updated(posterior, at, right)
            theirs.update(intensity=intensity, response="right" if correct else "wrong")
