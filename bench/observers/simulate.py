"""Observers of a stated model: how many are needed, and files as the page writes them.

Nobody has looked. A simulated observer has thresholds, slopes and a lapse rate; whoever guesses has
a lapse rate of one half.
"""

import math
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from scipy import stats

from bench.observers import plan as fixed
from bench.observers.plan import FITTED_LEVELS, STAIRCASE, TRIALS
from bench.observers.psychometric import AT_75, SLOPE_PRIOR, Fits, chance_correct, fit


@dataclass(frozen=True)
class ObserverModel:
    """A population of observers that is assumed.

    thresholds   least and greatest mean log₁₀ τ₇₅ of conditions, which are even between them
    observers, conditions   deviations of log₁₀ τ₇₅ between observers, and of one between conditions
    slope        median of β, and the deviation of ln β
    lapse        mean λ of a Beta distribution whose first parameter is 1
    """

    thresholds: tuple[float, float] = (0.15, 0.75)
    observers: float = 0.13
    conditions: float = 0.08
    slope: tuple[float, float] = SLOPE_PRIOR
    lapse: float = 0.025

    def means(self, conditions: int) -> np.ndarray:
        """Return log₁₀ τ₇₅ of every condition, (conditions,)."""
        return np.linspace(*self.thresholds, conditions)


@dataclass(frozen=True)
class Answers:
    """True log₁₀ τ₇₅, (n, conditions); levels shown and right answers, (n, conditions, trials)."""

    log75: np.ndarray
    level: np.ndarray
    correct: np.ndarray

    def fitted(self) -> Fits:
        """Fit every observer in every condition, (n·conditions,)."""
        right, shown = fixed.counts(self.level, self.correct)
        size = len(FITTED_LEVELS)
        return fit(FITTED_LEVELS, right.reshape(-1, size), shown.reshape(-1, size))


def ask(
    model: ObserverModel,
    lapse: np.ndarray,
    conditions: int,
    rng: np.random.Generator,
    trials: int = TRIALS,
) -> Answers:
    """Send an observer of each lapse rate (n,), NaN drawn, through staircases and catch trials."""
    n, shape = len(lapse), (len(lapse), conditions)
    lapse = np.where(np.isnan(lapse), rng.beta(1, 1 / model.lapse - 1, n), lapse)
    own = rng.normal(0, model.observers, (n, 1)) + rng.normal(0, model.conditions, shape)
    log75 = model.means(conditions) + own
    slope = model.slope[0] * np.exp(model.slope[1] * rng.normal(size=shape))
    slope, alpha, lapses = (
        each.ravel() for each in (slope, log75 - AT_75 / slope, np.repeat(lapse, conditions))
    )
    posterior, levels, told = STAIRCASE.start(n * conditions), [], []
    for trial in range(trials + fixed.CATCHES):
        caught = trial >= trials
        easiest = np.full(len(slope), len(STAIRCASE.levels))
        level = easiest if caught else STAIRCASE.next_level(posterior)
        chance = chance_correct(np.array(FITTED_LEVELS)[level], alpha, slope, lapses)
        correct = rng.random(len(slope)) < chance
        if not caught:
            posterior = STAIRCASE.updated(posterior, level, correct)
        levels.append(level)
        told.append(correct)
    level, correct = (np.stack(each, axis=1).reshape(*shape, -1) for each in (levels, told))
    return Answers(log75, level, correct)


WANTED = 0.15  # how far off τ₇₅ of a condition the end of its interval may be, as a share


def power(conditions: int, model: ObserverModel) -> list[dict[str, float]]:
    """Calculate how many observers find τ₇₅ of a condition within ±15 %, for numbers of trials.

    The deviation of an estimate is that of simulated staircases, with the assumed ones of people.
    """
    rows: list[dict[str, float]] = []
    for trials in (12, TRIALS, 48):
        rng = np.random.default_rng(0)
        said = ask(model, np.full(120, math.nan), fixed.BLOCK, rng, trials)
        error = float(np.std(said.fitted().value - said.log75.ravel()))
        total = math.hypot(error, model.observers, model.conditions)
        n = 2
        while stats.t.ppf(0.975, n - 1) * total / math.sqrt(n) > math.log10(1 + WANTED):
            n += 1
        everyone = math.ceil(n * conditions / min(fixed.BLOCK, conditions))
        row = {"trials": trials, "deviation": round(error, 3), "each": n, "observers": everyone}
        rows.append(row)
    return rows


def simulated_sessions(
    plan: Mapping[str, Any], lapse: Sequence[float], model: ObserverModel, seed: int
) -> Iterator[dict[str, Any]]:
    """Yield the content of the result file of each observer, numbered from 1."""
    rng = np.random.default_rng(seed)
    said = ask(model, np.array(lapse), len(plan["conditions"]), rng)
    for who, (levels, correct) in enumerate(zip(said.level, said.correct, strict=True)):
        block = plan["blocks"][who % len(plan["blocks"])]
        coming = {k: iter(zip(levels[k], correct[k], strict=True)) for k in block}
        trials = []
        for condition in rng.permutation(np.repeat(block, levels.shape[1])).tolist():
            level, right = map(int, next(coming[condition]))
            side = int(rng.integers(2))
            trial = {"condition": condition, "caught": level == len(STAIRCASE.levels)}
            answer = {"side": side, "answer": side if right else 1 - side}
            ms = 500 + int(rng.exponential(1500))
            trials.append({**trial, "level": level, **answer, "ms": ms})
        yield {
            "plan": plan["sha256"],
            "observer": who + 1,
            "session": f"simulated-{seed}-{who + 1}",
            "started": "2000-01-01T00:00:00.000Z",
            "finished": "2000-01-01T00:15:00.000Z",
            "screen": {"millipixels_per_degree": round(1000 * fixed.PIXELS_PER_DEGREE)},
            "trials": trials,
        }
