// How the search went: the best score against the evaluations spent, as a step plot.

const kSvg = "http://www.w3.org/2000/svg";

function svg(name, attributes, ...children) {
  const node = document.createElementNS(kSvg, name);
  for (const [key, value] of Object.entries(attributes || {})) node.setAttribute(key, value);
  node.append(...children);
  return node;
}

// Round numbers that divide [low, high] into about `pieces`.
function round_ticks(low, high, pieces) {
  const rough = (high - low) / pieces, power = 10 ** Math.floor(Math.log10(rough));
  const step = [1, 2, 5, 10].map((m) => m * power).find((s) => s >= rough);
  const ticks = [];
  for (let i = Math.ceil(low / step - 1e-9); i * step <= high + 1e-9 * step; ++i)
    ticks.push(Number((i * step).toPrecision(12)));
  return ticks;
}

const short_count = (n) => (n >= 1e6 ? `${n / 1e6}M` : n >= 1e3 ? `${n / 1e3}k` : String(n));

function draw_trace(host, facts) {
  const steps = facts.trace.filter((step) => step.score !== null);
  if (!steps.length) {
    host.replaceChildren(element("p", {class: "muted"}, "No trace was recorded."));
    return;
  }
  const end = Math.max(facts.evaluations, steps[steps.length - 1].evaluations, 2);
  // Searches improve early; a logarithmic axis keeps that from being one vertical line.
  const logarithmic = end > 50 && steps.some((step) => step.evaluations < end / 20);
  const scores = steps.map((step) => step.score);
  let low = Math.min(...scores), high = Math.max(...scores);
  if (high - low < 1e-9 * Math.max(1, Math.abs(high))) [low, high] = [low - 1, high + 1];
  const pad = 0.08 * (high - low);

  const width = Math.max(280, host.clientWidth), height = Math.min(220, Math.max(165, 0.42 * width));
  const frame = {left: 40, right: width - 10, top: 10, bottom: height - 36};
  const fraction = (n) => (logarithmic ? Math.log(Math.max(1, n)) / Math.log(end) : n / end);
  const x = (n) => frame.left + fraction(n) * (frame.right - frame.left);
  const y = (score) => frame.bottom - ((score - low + pad) / (high - low + 2 * pad)) * (frame.bottom - frame.top);
  const best = steps[steps.length - 1];
  const root = svg("svg", {
    viewBox: `0 0 ${width} ${height}`,
    role: "img",
    "aria-label": `Best score against evaluations: ${steps.length} improvements, the last at evaluation ${
        best.evaluations} with score ${fixed(best.score, 3)}.`
  });

  for (const tick of round_ticks(low - pad, high + pad, 4)) {
    root.append(
        svg("line", {class: "grid", x1: frame.left, x2: frame.right, y1: y(tick), y2: y(tick)}),
        svg("text", {x: frame.left - 6, y: y(tick) + 4, "text-anchor": "end"}, with_minus(String(tick))));
  }
  let ticks = round_ticks(0, end, 4);
  if (logarithmic) {
    ticks = [];
    for (let n = 1; n <= end; n *= 10) ticks.push(n);
    if (ticks.length > 6) ticks = ticks.filter((_, i) => i % 2 === 0);
  }
  for (const tick of ticks) {
    root.append(
        svg("line", {class: "axis", x1: x(tick), x2: x(tick), y1: frame.bottom, y2: frame.bottom + 4}),
        svg("text", {x: Math.min(x(tick), frame.right - 6), y: frame.bottom + 16, "text-anchor": "middle"},
            short_count(tick)));
  }
  root.append(
      svg("line", {class: "axis", x1: frame.left, x2: frame.right, y1: frame.bottom, y2: frame.bottom}),
      svg("text", {x: (frame.left + frame.right) / 2, y: height - 4, "text-anchor": "middle"},
          logarithmic ? "evaluations (logarithmic)" : "evaluations"));

  // One line while no design achieves the task, another from the first that does.
  for (const achieved of [false, true]) {
    const own = steps.filter((step) => step.achieved === achieved);
    if (!own.length) continue;
    let d = "";
    own.forEach((step, i) => {
      const index = steps.indexOf(step), next = steps[index + 1];
      d += `${i ? "V" : `M${x(step.evaluations)} `}${y(step.score)}H${x(next ? next.evaluations : end)}`;
      if (next && next.achieved !== achieved) d += `V${y(next.score)}`;
    });
    root.append(svg("path", {class: achieved ? "step" : "step pending", d}));
  }
  for (const step of steps) {
    root.append(svg("circle", {
      class: step.achieved ? "dot" : "dot pending",
      cx: x(step.evaluations),
      cy: y(step.score),
      r: steps.length > 40 ? 2.5 : 3.5
    }));
  }
  let note = "";
  if (steps.some((step) => step.achieved) && steps.some((step) => !step.achieved)) {
    note = element("p", {class: "muted"}, "Dashed: the best design did not achieve the task yet.");
  }

  const cursor = svg("line", {class: "cursor", y1: frame.top, y2: frame.bottom, visibility: "hidden"});
  root.append(cursor);
  const tip = element("div", {class: "tip", hidden: ""});
  const leave = () => {
    tip.hidden = true;
    cursor.setAttribute("visibility", "hidden");
  };
  root.addEventListener("pointerleave", leave);
  root.addEventListener("pointermove", (event) => {
    const box = root.getBoundingClientRect(), at = ((event.clientX - box.left) / box.width) * width;
    const step = steps.filter((own) => x(own.evaluations) <= at + 3).pop();
    if (!step) return leave();
    tip.textContent = `${fixed(step.score, 3)} since evaluation ${count(step.evaluations)} (${duration(step.seconds)})`;
    tip.hidden = false;
    cursor.setAttribute("x1", at);
    cursor.setAttribute("x2", at);
    cursor.setAttribute("visibility", "visible");
    const left = event.clientX - box.left;
    tip.style.left = `${Math.max(0, Math.min(left + 10, box.width - tip.offsetWidth))}px`;
    tip.style.top = `${Math.max(0, (y(step.score) / height) * box.height - 30)}px`;
  });
  host.replaceChildren(root, tip, note);
}
