"""Observers of a stated model: how many are needed, and files as the page writes them.

Nobody has looked. A simulated observer has a threshold, a slope and a lapse rate; whoever guesses
has a lapse rate of 1, and a lapser one of LAPSER.
"""

import math
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any, Literal

import numpy as np
from scipy import stats

from bench.observers.plan import BLOCK, CATCHES, FITTED_LEVELS, PIXELS_PER_DEGREE, STAIRCASE, TRIALS
from bench.observers.psychometric import AT_75, SLOPE_PRIOR, chance_correct, fit
from bench.observers.results import result_text


@dataclass(frozen=True)
class ObserverModel:
    """A population of observers that is assumed: for power, and for those who are simulated.

    thresholds  least and greatest log₁₀ τ₇₅ of conditions, which are even between them
    observers   deviation of log₁₀ τ₇₅ between observers, in all conditions alike
    conditions  the same of one observer from condition to condition
    slope       median of β, and the deviation of ln β
    lapse       mean λ of a Beta distribution whose first parameter is 1
    """

    thresholds: tuple[float, float] = (0.15, 0.75)
    observers: float = 0.13
    conditions: float = 0.08
    slope: tuple[float, float] = SLOPE_PRIOR
    lapse: float = 0.025


@dataclass(frozen=True)
class Observers:
    """Simulated observers, (n, conditions) each but ``lapse``, (n,), and the means (conditions,).

    log75  log₁₀ τ₇₅ of each in each condition
    """

    mean: np.ndarray
    log75: np.ndarray
    slope: np.ndarray
    lapse: np.ndarray

    def chance(self, who: np.ndarray, condition: np.ndarray, level: np.ndarray) -> np.ndarray:
        """Return the probability of a right answer of each observer named, at a level's number."""
        slope = self.slope[who, condition]
        alpha = self.log75[who, condition] - AT_75 / slope
        return chance_correct(np.array(FITTED_LEVELS)[level], alpha, slope, self.lapse[who])


def draw(model: ObserverModel, count: int, conditions: int, rng: np.random.Generator) -> Observers:
    """Draw observers of a model."""
    mean = np.linspace(*model.thresholds, conditions)
    own = rng.normal(0, model.observers, (count, 1))
    log75 = mean + own + rng.normal(0, model.conditions, (count, conditions))
    slope = model.slope[0] * np.exp(model.slope[1] * rng.normal(size=(count, conditions)))
    return Observers(mean, log75, slope, rng.beta(1, 1 / model.lapse - 1, count))


def ask(
    people: Observers, who: np.ndarray, condition: np.ndarray, trials: int, rng: np.random.Generator
) -> tuple[np.ndarray, np.ndarray]:
    """Run n staircases and their catch trials: right answers and trials shown, (n, levels) each."""
    rows, posterior = np.arange(len(who)), STAIRCASE.start(len(who))
    right, shown = np.zeros((2, len(who), len(FITTED_LEVELS)), np.int64)
    for _ in range(trials):
        level = STAIRCASE.next_level(posterior)
        correct = rng.random(len(who)) < people.chance(who, condition, level)
        posterior = STAIRCASE.updated(posterior, level, correct)
        right[rows, level] += correct
        shown[rows, level] += 1
    easiest = np.full(len(who), len(FITTED_LEVELS) - 1)
    shown[:, -1] = CATCHES
    right[:, -1] = rng.binomial(CATCHES, people.chance(who, condition, easiest))
    return right, shown


WANTED = 0.15
"""How far off τ₇₅ of a condition the end of its interval may be, as a share."""


def power(conditions: int, model: ObserverModel, seed: int = 0) -> list[dict[str, float]]:
    """Calculate how many observers find τ₇₅ of a condition within ±15 %, for numbers of trials.

    The deviation of one observer's estimate is that of simulated staircases of as many trials; to
    it come the assumed ones between observers and conditions. Student's t makes the interval.
    """
    rows = []
    for trials in (12, 18, TRIALS, 32, 48):
        rng = np.random.default_rng(seed)
        people, who = draw(model, 120, 6, rng), np.repeat(np.arange(120), 6)
        condition = np.tile(np.arange(6), 120)
        found = fit(FITTED_LEVELS, *ask(people, who, condition, trials, rng))
        error = float(np.std(found.value - people.log75.ravel()))
        total = math.hypot(error, model.observers, model.conditions)
        need = next(
            n
            for n in range(2, 1000)
            if stats.t.ppf(0.975, n - 1) * total / math.sqrt(n) <= math.log10(1 + WANTED)
        )
        share = min(BLOCK, conditions) / conditions
        observers = math.ceil(need / share)
        rows.append(
            {"trials": trials, "deviation": round(error, 3), "each": need, "observers": observers}
        )
    return rows


LAPSER = 0.5

Kind = Literal["observer", "guesser", "lapser"]


def simulated_files(
    plan: Mapping[str, Any], kinds: Sequence[Kind], model: ObserverModel, seed: int
) -> Iterator[tuple[str, str]]:
    """Yield the name and text of the result file of each observer, numbered from 1.

    They sit where they were asked to, and answer in half a second or more.
    """
    rng = np.random.default_rng(seed)
    people = draw(model, len(kinds), len(plan["conditions"]), rng)
    of_kind = {"guesser": 1.0, "lapser": LAPSER}
    lapse = [of_kind.get(kind, own) for kind, own in zip(kinds, people.lapse, strict=True)]
    people = replace(people, lapse=np.array(lapse))
    for who in range(len(kinds)):
        block = plan["blocks"][who % len(plan["blocks"])]
        content = {
            "plan": plan["sha256"],
            "observer": who + 1,
            "session": f"simulated-{seed}-{who + 1}",
            "started": "2000-01-01T00:00:00.000Z",
            "finished": "2000-01-01T00:15:00.000Z",
            "screen": {"millipixels_per_degree": round(1000 * PIXELS_PER_DEGREE)},
            "trials": list(_session(people, who, block, rng)),
        }
        yield f"observer-{who + 1:04d}-simulated-{seed}.json", result_text(content)


def _session(
    people: Observers, who: int, block: Sequence[int], rng: np.random.Generator
) -> Iterator[dict[str, Any]]:
    slots = [
        (k, caught) for k in range(len(block)) for caught in [False] * TRIALS + [True] * CATCHES
    ]
    posterior = STAIRCASE.start(len(block))
    for k, caught in rng.permutation(np.array(slots, object)).tolist():
        level = (
            len(STAIRCASE.levels) if caught else int(STAIRCASE.next_level(posterior[k : k + 1])[0])
        )
        at = np.array([who]), np.array([block[k]]), np.array([level])
        correct = bool(rng.random() < people.chance(*at)[0])
        if not caught:
            after = STAIRCASE.updated(posterior[k : k + 1], at[2], np.array([correct]))
            posterior[k] = after[0]
        side = int(rng.integers(2))
        yield {
            "condition": block[k],
            "caught": caught,
            "level": level,
            "side": side,
            "answer": side if correct else 1 - side,
            "ms": 500 + int(rng.exponential(1500)),
        }
