"use strict";
// Plots are drawn when they come near the screen; without this script their still pictures stay.
(() => {
  const axis = { zeroline: false, ticks: "outside", ticklen: 4, tickcolor: "#595959" };
  const common = {
    autosize: true, hovermode: "closest", paper_bgcolor: "#fff", plot_bgcolor: "#fff",
    font: { family: "system-ui, DejaVu Sans, sans-serif", size: 13, color: "#1b1b1b" },
    margin: { l: 64, r: 12, t: 8, b: 48 },
    legend: { orientation: "h", x: 0, y: -0.2, yanchor: "top" },
    // A finger scrolls the page; a mouse may zoom in, a double click shows all again.
    dragmode: matchMedia("(pointer: fine)").matches ? "zoom" : false,
  };
  const told = document.getElementById("told");

  const draw = (figure) => {
    const { data, layout } = JSON.parse(figure.querySelector("script").textContent);
    const frame = figure.querySelector(".plot");
    const inner = frame.firstElementChild;
    for (const key of Object.keys(layout)) {
      if (/^[xy]axis/.test(key)) {
        layout[key] = { ...axis, ...layout[key] };
        layout[key].title = { ...layout[key].title, standoff: 8 };
      }
    }
    frame.hidden = false;
    figure.classList.add("drawn");
    const config = { displayModeBar: false, responsive: true, showTips: false };
    Plotly.newPlot(inner, data, { ...common, ...layout }, config).then(() => walk(frame, inner));
  };

  // Arrow keys go from point to point and from series to series, and say where they are.
  const walk = (frame, inner) => {
    const series = inner.data.map((trace, number) => ({ trace, number }))
      .filter((each) => each.trace.hoverinfo !== "skip" && each.trace.x.length);
    let row = 0, at = -1;
    frame.addEventListener("keydown", (event) => {
      const step = { ArrowRight: [0, 1], ArrowLeft: [0, -1], ArrowDown: [1, 0], ArrowUp: [-1, 0] };
      if (event.key === "Escape") { Plotly.Fx.unhover(inner); return; }
      const move = step[event.key];
      if (!move) return;
      event.preventDefault();
      row = (row + move[0] + series.length) % series.length;
      const { trace, number } = series[row];
      at = Math.min(Math.max(at + move[1], 0), trace.x.length - 1);
      const axes = trace.yaxis === "y2" ? "xy2" : "xy";
      Plotly.Fx.hover(inner, [{ curveNumber: number, pointNumber: at }], axes);
      told.textContent = `${trace.name}: ${trace.y[at].toPrecision(4)} at ${trace.x[at].toPrecision(4)}`;
    });
    frame.addEventListener("blur", () => Plotly.Fx.unhover(inner));
  };

  const near = new IntersectionObserver((entries) => {
    for (const entry of entries) {
      if (entry.isIntersecting) { near.unobserve(entry.target); draw(entry.target); }
    }
  }, { rootMargin: "400px" });
  document.querySelectorAll("figure.interactive").forEach((figure) => near.observe(figure));

  // Pictures laid over each other: the slider says how much of the upper one is seen.
  document.querySelectorAll("figure.pictures").forEach((figure) => {
    const [under, over] = figure.querySelectorAll("img");
    const slider = figure.querySelector("input");
    const show = () => figure.style.setProperty("--at", `${slider.value}%`);
    slider.addEventListener("input", show);
    const choose = (select, image) => {
      const take = () => {
        const chosen = select.selectedOptions[0];
        image.src = chosen.dataset.src;
        image.alt = chosen.dataset.alt;
      };
      select.addEventListener("change", take);
      take();
    };
    const [left, right] = figure.querySelectorAll("select");
    choose(left, over);
    choose(right, under);
    figure.classList.add("drawn");
    show();
  });
})();
