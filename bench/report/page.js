"use strict";
// Without this script plots and pictures stand still, and the browser tells a plot's points.
(() => {
  const told = document.getElementById("told");

  // The point nearest to the pointer, or the one that arrow keys go to, tells its numbers: left and
  // right go from point to point, up and down from curve to curve. A click or Enter enlarges.
  document.querySelectorAll("figure.plot .panel").forEach((figure) => {
    const svg = figure.querySelector("svg");
    const marks = [...svg.querySelectorAll(".mark")];
    const tip = Object.assign(document.createElement("div"), { className: "tip", hidden: true });
    const words = new Map(marks.map((mark) => [mark, mark.querySelector("title").textContent]));
    const numbers = [...new Set(marks.map((mark) => mark.dataset.curve))];
    const curves = numbers.map((curve) => marks.filter((mark) => mark.dataset.curve === curve));
    let shown = null, row = 0, at = -1;
    marks.forEach((mark) => mark.querySelector("title").remove());
    svg.after(tip);
    svg.tabIndex = 0;
    svg.setAttribute("aria-label", `${svg.getAttribute("aria-label")} Arrow keys tell its points.`);

    const middle = (mark) => {
      const { x, y, width, height } = mark.getBoundingClientRect();
      return [x + width / 2, y + height / 2];
    };
    const show = (mark) => {
      shown?.classList.remove("told");
      mark?.classList.add("told");
      shown = mark;
      tip.hidden = !mark;
      if (!mark) return;
      tip.textContent = words.get(mark);
      const frame = figure.getBoundingClientRect(), [x, y] = middle(mark);
      tip.style.left = `${Math.max(0, Math.min(x - frame.x + 10, frame.width - tip.offsetWidth))}px`;
      tip.style.top = `${y - frame.y - tip.offsetHeight - 10}px`;
    };
    const enlarge = () => { show(null); figure.classList.toggle("large"); };

    svg.addEventListener("pointermove", (event) => {
      const far = (mark) => Math.hypot(...middle(mark).map((v, k) => v - [event.x, event.y][k]));
      const near = marks.map((mark) => [far(mark), mark]).sort((a, b) => a[0] - b[0])[0];
      show(near && near[0] < 24 ? near[1] : null);
    });
    svg.addEventListener("pointerleave", () => show(null));
    svg.addEventListener("blur", () => show(null));
    svg.addEventListener("click", enlarge);
    svg.addEventListener("keydown", (event) => {
      const step = { ArrowRight: [0, 1], ArrowLeft: [0, -1], ArrowDown: [1, 0], ArrowUp: [-1, 0] };
      if (event.key === "Escape") return show(null);
      if (event.key === "Enter") return enlarge();
      const move = step[event.key];
      if (!move || !curves.length) return;
      event.preventDefault();
      row = (row + move[0] + curves.length) % curves.length;
      at = Math.min(Math.max(at + move[1], 0), curves[row].length - 1);
      show(curves[row][at]);
      told.textContent = words.get(shown);
    });
  });

  // On a narrow screen rows become cards: their cells say what they are, and stay cells.
  document.querySelectorAll("table.claims").forEach((table) => {
    const heads = [...table.tHead.rows[0].cells].map((head) => head.textContent);
    const roles = { TABLE: "table", THEAD: "rowgroup", TBODY: "rowgroup", TR: "row", TH: "columnheader", TD: "cell" };
    [table, ...table.querySelectorAll("thead, tbody, tr, th, td")].forEach((each) => {
      each.setAttribute("role", roles[each.tagName]);
      if (each.tagName === "TD" && each.cellIndex > 0) each.dataset.head = heads[each.cellIndex];
    });
  });

  // Pictures laid over each other: the slider says how much of the upper one is seen.
  document.querySelectorAll("figure.pictures").forEach((figure) => {
    const images = [...figure.querySelectorAll("img")];
    const slider = figure.querySelector("input");
    const sides = [...figure.querySelectorAll("select")];
    const show = () => figure.style.setProperty("--at", `${slider.value}%`);
    const choose = () => {
      const [left, right] = sides.map((each) => each.selectedIndex);
      images.forEach((image, k) => {
        image.className = k === right ? "under" : "";
        if (k === left) image.classList.add("over");
      });
    };
    sides.forEach((each) => each.addEventListener("change", choose));
    slider.addEventListener("input", show);
    figure.classList.add("drawn");
    choose();
    show();
  });
})();
