// QUEST+ (Watson 2017) over the plan's grid, and a generator of chance with a seed.
"use strict";

class Quest {
  constructor(staircase) {
    const { levels, thresholds, slopes, lapses, guess } = staircase;
    this.right = levels.map((x) => {
      const row = [];
      for (const alpha of thresholds)
        for (const beta of slopes)
          for (const lapse of lapses)
            row.push(1 - lapse - (1 - guess - lapse) * Math.exp(-(10 ** (beta * (x - alpha)))));
      return row;
    });
    this.known = this.right.map((row) => row.map(information));
    this.posterior = this.right[0].map((_, __, row) => 1 / row.length);
  }

  // The number of the level after which the expected entropy is least; the first of equal ones.
  next() {
    let best = 0;
    let least = Infinity;
    this.right.forEach((row, level) => {
      const entropy = information(dot(this.posterior, row)) - dot(this.posterior, this.known[level]);
      if (entropy < least) [best, least] = [level, entropy];
    });
    return best;
  }

  update(level, correct) {
    const row = this.right[level];
    this.posterior = this.posterior.map((w, k) => w * (correct ? row[k] : 1 - row[k]));
    const sum = this.posterior.reduce((a, b) => a + b);
    this.posterior = this.posterior.map((w) => w / sum);
  }
}

const information = (p) => p * Math.log(p) + (1 - p) * Math.log1p(-p);
const dot = (a, b) => a.reduce((sum, value, k) => sum + value * b[k], 0);

// A small generator (mulberry32): the same seed gives the same order, so that a session resumes.
function chance(seed) {
  let a = seed >>> 0;
  return () => {
    a = (a + 0x6d2b79f5) | 0;
    let t = Math.imul(a ^ (a >>> 15), 1 | a);
    t = (t + Math.imul(t ^ (t >>> 7), 61 | t)) ^ t;
    return ((t ^ (t >>> 14)) >>> 0) / 4294967296;
  };
}

function shuffled(items, random) {
  const made = [...items];
  for (let k = made.length - 1; k > 0; k--) {
    const other = Math.floor(random() * (k + 1));
    [made[k], made[other]] = [made[other], made[k]];
  }
  return made;
}

// What one observer is shown, as a function of the answers so far.
class Protocol {
  constructor(plan, observer) {
    const random = chance(1000003 * observer + plan.seed);
    this.block = plan.blocks[(observer - 1) % plan.blocks.length];
    const slots = this.block.flatMap((condition) => [
      ...Array(plan.trials).fill({ condition, caught: false }),
      ...Array(plan.catches).fill({ condition, caught: true }),
    ]);
    this.slots = shuffled(slots, random).map((slot) => ({ ...slot, side: random() < 0.5 ? 0 : 1 }));
    this.stairs = new Map(this.block.map((condition) => [condition, new Quest(plan.staircase)]));
    this.easiest = plan.staircase.levels.length;
    this.done = 0;
  }

  // The next trial: its condition, its level, and on which side the pruned picture is.
  next() {
    const slot = this.slots[this.done];
    if (!slot) return null;
    const level = slot.caught ? this.easiest : this.stairs.get(slot.condition).next();
    return { ...slot, level };
  }

  answered(trial) {
    const correct = trial.answer === trial.side;
    if (!trial.caught) this.stairs.get(trial.condition).update(trial.level, correct);
    this.done += 1;
  }
}
