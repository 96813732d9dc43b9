// The experiment: consent, calibration, practice, trials and the file, on jsPsych's timeline.
"use strict";

const PLAN = JSON.parse(document.getElementById("plan").textContent);
const CARD_MM = 85.6;
const [WIDTH, HEIGHT] = PLAN.size;
const jsPsych = initJsPsych({ display_element: "page", override_safe_mode: true });
let content = null; // what the file will hold
let protocol = null;
let box = null;

const key = (observer) => `lodbench-observe:${PLAN.sha256}:${observer}`;
const scale = () => window.devicePixelRatio || 1;

function keep() {
  try {
    localStorage.setItem(key(content.observer), JSON.stringify(content));
  } catch {
    return false;
  }
  return true;
}

function kept(observer) {
  try {
    return JSON.parse(localStorage.getItem(key(observer)));
  } catch {
    return null;
  }
}

// Sorted keys and no blanks; all numbers are whole, so that every language writes them alike.
function canonical(value) {
  if (Array.isArray(value)) return `[${value.map(canonical).join(",")}]`;
  if (value === null || typeof value !== "object") return JSON.stringify(value);
  const names = Object.keys(value).sort();
  return `{${names.map((name) => `${JSON.stringify(name)}:${canonical(value[name])}`).join(",")}}`;
}

async function file() {
  const text = canonical(content);
  const hash = await crypto.subtle.digest("SHA-256", new TextEncoder().encode(text));
  const sha256 = [...new Uint8Array(hash)].map((b) => b.toString(16).padStart(2, "0")).join("");
  return `{"format":"${PLAN.format}","format_version":${PLAN.format_version},"sha256":"${sha256}",\n"content":${text}}\n`;
}

// A sheet of text with fields. `check` reads them; what it returns is said, and nothing goes on.
class SheetPlugin {
  static info = { name: "sheet", version: "1.0", parameters: {}, data: {} };

  trial(element, trial) {
    element.innerHTML = `<form class="sheet">${trial.html()}<p class="wrong" role="alert"></p>
      <button type="submit" name="on">${trial.button ?? "Continue"}</button></form>`;
    const form = element.firstElementChild;
    const finish = (data) => {
      element.innerHTML = "";
      jsPsych.finishTrial(data);
    };
    form.onsubmit = (event) => {
      event.preventDefault();
      const wrong = trial.check?.(form);
      if (wrong) form.querySelector(".wrong").textContent = wrong;
      else finish({ pressed: "on" });
    };
    trial.prepare?.(form, finish);
    (form.querySelector("input") ?? form.elements.on).focus();
  }
}

const wait = (ms) => new Promise((done) => setTimeout(done, ms));
const picture = (source, label) => {
  const size = `width:${WIDTH / scale()}px;height:${HEIGHT / scale()}px`;
  return `<figure><figcaption>${label}</figcaption>
    <img src="${source}" alt="${label} picture" style="${size}"></figure>`;
};

// One forced choice: stills side by side below the reference, or clips one after the other.
class ChoicePlugin {
  static info = { name: "choice", version: "1.0", parameters: {}, data: {} };

  async trial(element, trial) {
    const { condition, level, side } = trial.shown();
    const shown = PLAN.conditions[condition];
    const pair = side === 0 ? [shown.levels[level], shown.again] : [shown.again, shown.levels[level]];
    const show = shown.moving ? this.clips : this.stills;
    const dropped = await show.call(this, element, shown.reference, pair, trial.title());
    const start = performance.now();
    for (;;) {
      const pressed = await this.pressed();
      if (pressed === "r" && shown.moving) {
        await this.clips(element, shown.reference, pair, trial.title());
      } else if (pressed !== "r") {
        const answer = pressed === "ArrowLeft" ? 0 : 1;
        element.innerHTML = "";
        const ms = Math.round(performance.now() - start);
        const times = shown.moving ? { dropped } : {};
        jsPsych.finishTrial({ trial: { ...trial.shown(), answer, ms, ...times } });
        return;
      }
    }
  }

  pressed() {
    return new Promise((done) => {
      jsPsych.pluginAPI.getKeyboardResponse({
        callback_function: (info) => done(info.key.length === 1 ? "r" : info.key.replace("arrow", "Arrow").replace("left", "Left").replace("right", "Right")),
        valid_responses: ["ArrowLeft", "ArrowRight", "r"],
        persist: false,
        allow_held_key: false,
      });
    });
  }

  async stills(element, reference, pair, title) {
    element.innerHTML = `<div class="trial hidden"><p>${title}</p>${picture(reference, "Reference")}
      <div class="row">${picture(pair[0], "← Left")}${picture(pair[1], "Right →")}</div>
      <p>Which of the two differs from the reference? Press ← or →.</p></div>`;
    await Promise.all([...element.querySelectorAll("img")].map((image) => image.decode()));
    element.firstElementChild.classList.remove("hidden");
    return 0;
  }

  async clips(element, reference, pair, title) {
    const size = `width:${WIDTH / scale()}px;height:${HEIGHT / scale()}px`;
    element.innerHTML = `<div class="trial"><p>${title}</p><p class="which">…</p>
      <video muted playsinline preload="auto" class="hidden" style="${size}"></video>
      <p class="hidden asked">Which of the two differed from the reference? Press ← for the first,
      → for the second, R to see all again.</p></div>`;
    const video = element.querySelector("video");
    const which = element.querySelector(".which");
    const labels = ["Reference", "First", "Second"];
    let dropped = 0;
    for (const [number, source] of [reference, ...pair].entries()) {
      const ready = new Promise((done) => (video.oncanplaythrough = done));
      video.src = source;
      video.load();
      await ready;
      which.textContent = labels[number];
      await wait(300);
      video.classList.remove("hidden");
      const ended = new Promise((done) => (video.onended = done));
      await video.play();
      await ended;
      dropped += video.getVideoPlaybackQuality?.().droppedVideoFrames ?? 0;
      video.classList.add("hidden");
    }
    which.textContent = "";
    element.querySelector(".asked").classList.remove("hidden");
    return dropped;
  }
}

const needed = () => [2 * WIDTH + 24, 2 * HEIGHT + 150].map((px) => Math.ceil(px / scale()));

const consent = {
  type: SheetPlugin,
  button: "I agree and take part",
  html: () => `<h1>What can be seen in pictures</h1>
    <p>You are asked to take part in an experiment on what people can see in computer-made pictures
    of landscapes. You compare pictures and short clips with a reference, and say which of two
    differs from it. Often there is little or nothing to be seen; then you guess, and that is as it
    should be. It takes about 25 minutes: 5 to set up, and 15 of pictures with breaks.</p>
    <p>Nothing harmful or upsetting is shown, and nothing flashes. Your eyes may tire; rest whenever you
    wish.</p>
    <p>The page keeps your answers, their times, the number that you were given, and the settings of
    the screen. It asks for no name, and sends nothing anywhere: at the end there is one file on this
    computer, and you decide whether to hand it over. You may stop at any time without a reason, by
    closing the page or in a break, and ask later for your file to be deleted by your number.</p>
    <p>Go on only if you are of age, have read this, and had your questions answered by whoever asked
    you.</p>`,
};

const number = {
  type: SheetPlugin,
  html: () => `<h1>Your number</h1><p>Use the number that you were given. With the same number on
    the same computer an unfinished session goes on where it was.</p>
    <label for="observer">Number, 1 to 9999</label>
    <input id="observer" type="number" min="1" max="9999" step="1">`,
  check: (form) => {
    const observer = Number(form.querySelector("input").value);
    if (!Number.isInteger(observer) || observer < 1 || observer > 9999)
      return "Please type a whole number from 1 to 9999.";
    const found = kept(observer);
    if (found?.finished) return "This number has finished already; please use the one you were given.";
    content = found ?? {
      plan: PLAN.sha256,
      observer,
      session: [...crypto.getRandomValues(new Uint8Array(8))].map((b) => b.toString(16).padStart(2, "0")).join(""),
      started: new Date().toISOString(),
      finished: "",
      screen: {},
      trials: [],
    };
    if (!keep()) return "This browser keeps nothing: please leave its private mode, and load the page again.";
    protocol = new Protocol(PLAN, observer);
    content.trials.forEach((trial) => protocol.answered(trial));
    return "";
  },
};

const slider = (label, least, most, value) => `<label for="slider">${label} (← → or the mouse)</label>
  <input id="slider" type="range" min="${least}" max="${most}" value="${value}">`;

const card = {
  type: SheetPlugin,
  html: () => `<h1>The size of the screen</h1><p>Hold a bank card (ISO ID-1, 85.6 mm wide) against
    the screen, and make the blue one as wide as it is.</p><div class="card"></div>
    ${slider("Width of the card", 150, 700, 340)}`,
  prepare: (form) => {
    const [input, blue] = [form.querySelector("input"), form.querySelector(".card")];
    const draw = () => {
      box = Number(input.value);
      blue.style.cssText = `width:${box}px;height:${(box * 53.98) / CARD_MM}px`;
    };
    input.oninput = draw;
    draw();
  },
  check: () => {
    content.screen.card_px = Math.round(box * scale());
    return "";
  },
};

const pixelsPerDegree = (mm) => {
  const perMm = content.screen.card_px / CARD_MM;
  return 2 * mm * Math.tan(Math.PI / 360) * perMm;
};

const distance = {
  type: SheetPlugin,
  html: () => {
    const cm = PLAN.pixels_per_degree / pixelsPerDegree(10);
    return `<h1>Where you sit</h1><p>Sit so that your eyes are <b>${Math.round(cm)} cm</b> from the
      screen, and stay there. Use a tape if you can. Wear the glasses that you use at this
      distance.</p><label for="cm">Distance of your eyes from the screen [cm]</label>
      <input id="cm" type="number" min="10" max="500" step="1" value="${Math.round(cm)}">`;
  },
  check: (form) => {
    const cm = Number(form.querySelector("input").value);
    if (!(cm >= 10 && cm <= 500)) return "Please type a distance from 10 to 500 cm.";
    content.screen.distance_mm = Math.round(10 * cm);
    content.screen.millipixels_per_degree = Math.round(1000 * pixelsPerDegree(10 * cm));
    return "";
  },
};

const grey = {
  type: SheetPlugin,
  html: () => `<h1>Grey</h1><p>Half close your eyes, and make the right half as bright as the lines on
    the left look from there.</p><div class="grey"><div class="lines"></div><div class="field"></div>
    </div>${slider("Brightness of the right half", 60, 250, 150)}`,
  prepare: (form) => shade(form, ".field"),
  check: (form) => {
    content.screen.grey = Number(form.querySelector("input").value);
    return "";
  },
};

const black = {
  type: SheetPlugin,
  html: () => `<h1>Black</h1><p>Make the square in the black field brighter until you just see
    it.</p><div class="black"><div></div></div>${slider("Brightness of the square", 0, 60, 0)}`,
  prepare: (form) => shade(form, ".black > *"),
  check: (form) => {
    content.screen.black = Number(form.querySelector("input").value);
    Object.assign(content.screen, {
      width: screen.width,
      height: screen.height,
      milliscale: Math.round(1000 * scale()),
    });
    keep();
    return "";
  },
};

function shade(form, where) {
  const [input, field] = [form.querySelector("input"), form.querySelector(where)];
  const draw = () => (field.style.background = `rgb(${input.value},${input.value},${input.value})`);
  input.oninput = draw;
  draw();
}

const instructions = {
  type: SheetPlugin,
  html: () => `<h1>What to do</h1><p>You see a <b>reference</b> and two others. One of the two is the
    same scene with parts left out, and the other is complete. Press <b>←</b> for the left or first,
    <b>→</b> for the right or second: whichever differs from the reference. The fine grain of the
    pictures differs everywhere, and does not count. Guess where you see no difference. Take the time you
    need.</p><p>Darken the room if you can, and make this window fill the screen (F11).
    First come ${PRACTICE} trials for practice, which are easy.</p>`,
  check: () => {
    const [wide, high] = needed();
    if (innerWidth < wide || innerHeight < high)
      return `This window shows ${innerWidth} × ${innerHeight}; the pictures need ${wide} × ${high}. Press F11, zoom out, or use a larger screen.`;
    return "";
  },
};

const PRACTICE = 3;
const easy = Array.from({ length: PRACTICE }, (_, k) => ({
  timeline: [
    {
      type: ChoicePlugin,
      title: () => `Practice ${k + 1} of ${PRACTICE}`,
      shown: () => ({ condition: protocol.block[k % protocol.block.length], level: protocol.easiest, side: (k + 1) % 2 }),
    },
    {
      type: SheetPlugin,
      html: () => {
        const { answer, side } = jsPsych.data.get().last(1).values()[0].trial;
        return answer === side
          ? "<h1>Right</h1><p>That one had parts left out.</p>"
          : "<h1>It was the other one</h1><p>The other one had parts left out.</p>";
      },
    },
  ],
}));

const setup = {
  timeline: [card, distance, grey, black, instructions, ...easy],
  conditional_function: () => content.screen.black === undefined || content.trials.length === 0,
};

const resumed = {
  timeline: [{
    ...instructions,
    html: () => `<h1>Welcome back</h1><p>${content.trials.length} of ${protocol.slots.length} answers are
      kept. Sit ${Math.round(content.screen.distance_mm / 10)} cm from the screen, as before.</p>`,
  }],
  conditional_function: () => content.trials.length > 0,
};

const rest = {
  timeline: [{
    type: SheetPlugin,
    html: () => `<h1>A break</h1><p>${protocol.done} of ${protocol.slots.length} are done, and kept. Look at
      something far away, and go on when you like.</p>`,
    prepare: (form, finish) => {
      const stop = document.createElement("button");
      stop.type = "button";
      stop.textContent = "Stop here";
      stop.onclick = () => {
        protocol.slots.length = protocol.done;
        finish({ pressed: "stop" });
      };
      form.append(stop);
    },
  }],
  conditional_function: () => protocol.done > 0 && protocol.done % PLAN.break_every === 0 && protocol.done < protocol.slots.length,
};

const trials = {
  timeline: [
    {
      type: ChoicePlugin,
      title: () => `${protocol.done + 1} of ${protocol.slots.length}`,
      shown: () => protocol.next(),
      on_finish: (data) => {
        content.trials.push(data.trial);
        protocol.answered(data.trial);
        keep();
      },
    },
    rest,
  ],
  loop_function: () => protocol.done < protocol.slots.length,
};

const main = { timeline: [trials], conditional_function: () => protocol.next() !== null };

const end = {
  type: SheetPlugin,
  button: "Save the file",
  html: () => `<h1>Thank you</h1><p>Save the file, and give it to whoever asked you. It holds your answers
    and the settings of the screen, and no name.</p>`,
  on_start: () => {
    const whole = content.trials.length === PLAN.block_trials;
    content.finished = whole ? new Date().toISOString() : "";
    keep();
  },
  check: (form) => {
    file().then((text) => {
      const link = document.createElement("a");
      link.href = URL.createObjectURL(new Blob([text], { type: "application/json" }));
      link.download = `observer-${String(content.observer).padStart(4, "0")}-${content.session}.json`;
      link.click();
    });
    return "Saved. You may save it again, or close the page.";
  },
};

jsPsych.run([consent, number, setup, resumed, main, end]);
