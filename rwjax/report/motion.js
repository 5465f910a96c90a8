// The held-out runs with zoom and hover, drawn by uPlot (rwjax/report/uplot) above the still figure, which stays for print.
(() => {
  const runs = JSON.parse(document.getElementById("motions").textContent);
  const panel = document.getElementById("zoom");
  const chosen = panel.querySelector("select");
  const place = document.getElementById("chart");
  const dark = matchMedia("(prefers-color-scheme: dark)");
  let chart = null;

  runs.forEach((run, k) => chosen.add(new Option(`${run.name}: ${run.label}`, k)));

  function draw() {
    const run = runs[chosen.value];
    const css = getComputedStyle(document.documentElement);
    const [text, line] = ["--text", "--line"].map((name) => css.getPropertyValue(name));
    const value = (_, v) => (v === null || v === undefined ? "–" : v.toPrecision(4));
    const axis = (label) => ({ stroke: text, grid: { stroke: line, width: 0.5 }, ticks: { stroke: line }, label });
    const curve = ({ label, colour, width, dash }) => ({ label, stroke: colour, width, dash, value });
    const thinned = run.every > 1 ? ` One of ${run.every} samples is drawn.` : "";
    document.getElementById("thinned").textContent = thinned;
    chart?.destroy();
    chart = new uPlot(
      {
        width: place.clientWidth,
        height: 320,
        scales: { x: { time: false } },
        axes: [axis("time [s]"), { ...axis(run.label), size: 64 }],
        series: [{ label: "time [s]", value }, ...run.curves.map(curve)],
      },
      [run.time, ...run.curves.map((one) => one.values)],
      place,
    );
  }

  function zoom(factor, shift) {
    const { min, max } = chart.scales.x;
    const [first, last] = [chart.data[0][0], chart.data[0].at(-1)];
    const width = Math.min((max - min) * factor, last - first);
    const middle = (min + max) / 2 + shift * (max - min);
    const from = Math.min(Math.max(middle - width / 2, first), last - width);
    chart.setScale("x", { min: from, max: from + width });
  }

  const moves = { in: [0.5, 0], out: [2, 0], back: [1, -0.5], on: [1, 0.5], whole: [Infinity, 0] };
  for (const button of panel.querySelectorAll("button")) {
    button.addEventListener("click", () => zoom(...moves[button.value]));
  }
  panel.hidden = false; // a hidden panel has no width
  try {
    draw();
  } catch (error) {
    panel.hidden = true;
    throw error;
  }
  document.getElementById("motion").closest("figure").classList.add("still");
  chosen.addEventListener("change", draw);
  dark.addEventListener("change", draw);
  addEventListener("resize", () => chart.setSize({ width: place.clientWidth, height: 320 }));
})();
