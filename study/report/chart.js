// One figure: a Chart.js line chart with a readout of all lines at the pointer, its values as a table, and a picture to
// save.

const kSuperscripts = "⁰¹²³⁴⁵⁶⁷⁸⁹";
function power_of_ten(value) {
  const exponent = Math.round(Math.log10(value));
  if (exponent >= 0 && exponent <= 3) return String(10 ** exponent);
  return "10" + (exponent < 0 ? "⁻" : "") + String(Math.abs(exponent)).split("").map((d) => kSuperscripts[d]).join("");
}

// Ticks of a logarithmic axis at powers of ten; where the axis spans less than two of them, at 2 and 5 as well.
function log_ticks(axis) {
  const low = Math.log10(axis.min), high = Math.log10(axis.max), stride = Math.max(1, Math.ceil((high - low) / 8));
  const ticks = [];
  for (let e = Math.floor(low); e <= Math.ceil(high); ++e) {
    for (const m of high - low < 2 ? [1, 2, 5] : [1]) {
      if (m === 1 && e % stride) continue;
      const value = m * 10 ** e;
      if (value >= axis.min * 0.999 && value <= axis.max * 1.001) ticks.push({value, major: m === 1});
    }
  }
  axis.ticks = ticks;
}
const log_label = (value) =>
    Math.abs(Math.log10(value) - Math.round(Math.log10(value))) < 1e-6 ? power_of_ten(value) : brief(value);

// A canvas has no ground of its own; a picture that is saved needs one.
const kGround = {
  id: "ground",
  beforeDraw(chart) {
    chart.ctx.fillStyle = css("--surface");
    chart.ctx.fillRect(0, 0, chart.width, chart.height);
  }
};

// Marks {x, y, colour, text} above the lines: where something happens. The text may be empty.
const kMarks = {
  id: "marks",
  afterDatasetsDraw(chart) {
    const {ctx, chartArea: area, scales} = chart;
    ctx.save();
    ctx.font = "12px system-ui, sans-serif";
    const placed = [];
    for (const mark of chart.options.marks || []) {
      const x = scales.x.getPixelForValue(mark.x), y = scales.y.getPixelForValue(mark.y);
      if (x < area.left || x > area.right) continue;
      if (mark.text) {
        ctx.strokeStyle = css("--muted");
        ctx.setLineDash([3, 3]);
        ctx.beginPath();
        ctx.moveTo(x, y);
        ctx.lineTo(x, area.bottom);
        ctx.stroke();
        ctx.setLineDash([]);
      }
      ctx.beginPath();
      ctx.arc(x, y, 5, 0, 2 * Math.PI);
      ctx.fillStyle = css("--surface");
      ctx.fill();
      ctx.lineWidth = 2;
      ctx.strokeStyle = mark.colour;
      ctx.stroke();
      ctx.lineWidth = 1;
      ctx.fillStyle = css("--ink");
      const width = ctx.measureText(mark.text).width;
      if (!mark.text || placed.some((other) => other.text === mark.text && Math.abs(other.x - x) < 2)) continue;
      const left = x + width + 12 > area.right ? x - 9 - width : x + 9;
      let base = Math.max(area.top + 12, y - 9);
      // Two marks beside each other: the later one is written above the earlier.
      const meets = (other) => left < other.left + other.width + 4 && other.left < left + width + 4 &&
                               Math.abs(base - other.base) < 14;
      for (let other = placed.find(meets); other && base > area.top + 26; other = placed.find(meets)) base = other.base - 14;
      placed.push({x, text: mark.text, left, width, base});
      ctx.textAlign = "left";
      ctx.fillText(mark.text, left, base);
    }
    ctx.restore();
  }
};

class Figure {
  constructor(host, title) {
    this.canvas = element("canvas", {role: "img"});
    this.caption = element("figcaption", {});
    this.readout = element("div", {class: "readout", hidden: "", "aria-hidden": "true"});
    this.empty = element("p", {class: "empty", hidden: ""});
    this.plot = element("div", {class: "plot"}, this.canvas, this.empty, this.readout);
    this.values = element("details", {}, element("summary", {}, "Values"), element("div", {class: "scroll"}));
    const save = element("button", {type: "button", title: "Save the figure as a picture"}, "PNG");
    save.addEventListener("click", () => this.save());
    host.append(element("figure", {}, element("div", {class: "head"}, element("h3", {}, title), save), this.caption,
                        this.plot, this.values));
    this.title = title;
    this.plot.addEventListener("pointermove", (event) => this.read(event));
    this.plot.addEventListener("pointerleave", () => this.leave());
  }

  save() {
    const link = element("a", {href: this.canvas.toDataURL("image/png"), download: `${this.title}.png`});
    link.click();
  }

  // lines: [{label, colour, dash, x, y, low?, high?, stepped, read?, absent?}], x increasing; null in y: not there (yet).
  // read(x): the line's value where it is not that of the last point; absent: what to say where there is none.
  // x and y: axes {title, log, min?, max?, form}, where form makes text of a value.
  show({note, lines, x, y, marks = [], nothing = "No run met this target."}) {
    this.lines = lines.filter((line) => line.x.length && line.y.some(is_number));
    this.axes = {x, y};
    this.caption.textContent = note;
    this.empty.textContent = nothing;
    this.empty.hidden = this.lines.length > 0;
    this.canvas.style.visibility = this.lines.length ? "visible" : "hidden";
    this.canvas.setAttribute("aria-label", `${this.title}. ${note} The values are in the table below.`);
    const datasets = [];
    for (const line of this.lines) {
      const points = (values) => line.x.map((at, i) => ({x: at, y: values[i]}));
      const base = {stepped: line.stepped, clip: 3, pointRadius: 0, borderColor: line.colour, spanGaps: false};
      if (line.low) {
        datasets.push({...base, data: points(line.low), borderWidth: 0},
                      {...base, data: points(line.high), borderWidth: 0, fill: "-1",
                       backgroundColor: translucent(line.colour, 0.16)});
      }
      datasets.push({...base, data: points(line.y), borderWidth: 2, borderDash: line.dash});
    }
    const axis = (own) => ({
      type: own.log ? "logarithmic" : "linear",
      min: own.min,
      max: own.max,
      title: {display: true, text: own.title, color: css("--muted"), font: {size: 12.5}},
      grid: {color: css("--line"), borderColor: css("--muted"), tickColor: css("--muted")},
      ticks: {color: css("--muted"), callback: own.log ? log_label : own.form, maxTicksLimit: 9, autoSkip: !own.log,
              maxRotation: 0},
      ...(own.log ? {afterBuildTicks: log_ticks} : {})
    });
    if (this.chart) this.chart.destroy();
    this.chart = new Chart(this.canvas, {
      type: "line",
      data: {datasets},
      plugins: [kGround, kMarks],
      options: {
        animation: false, parsing: false, normalized: true, responsive: true, maintainAspectRatio: false, marks,
        events: [], plugins: {legend: {display: false}, tooltip: {enabled: false}},
        scales: {x: axis(x), y: axis(y)}
      }
    });
    this.fill_values();
  }

  // What a line says at `at`, in words.
  answer(line, at) {
    const value = line.read ? line.read(at) : value_at(line, at);
    return is_number(value) ? this.axes.y.form(value) : line.absent || kDash;
  }

  read(event) {
    if (!this.lines.length) return;
    const {scales, chartArea: area} = this.chart, box = this.plot.getBoundingClientRect();
    const px = event.clientX - box.left;
    if (px < area.left || px > area.right) return this.leave();
    const at = scales.x.getValueForPixel(px), {x} = this.axes;
    const rows = this.lines.map((line) => {
      const dot = element("span", {class: "dot"});
      dot.style.background = line.colour;
      return element("div", {class: "row"}, dot, element("span", {}, line.label),
                     element("span", {}, this.answer(line, at)));
    });
    this.readout.replaceChildren(element("b", {}, `${x.title}: ${x.form(at)}`), ...rows);
    this.readout.hidden = false;
    const left = px + 14 + this.readout.offsetWidth > box.width ? px - 14 - this.readout.offsetWidth : px + 14;
    this.readout.style.left = `${Math.max(0, left)}px`;
    this.readout.style.top = `${area.top + 6}px`;
  }
  leave() { this.readout.hidden = true; }

  // The same numbers for who cannot see the lines, at the ticks of the axis.
  fill_values() {
    const ticks = this.lines.length ? this.chart.scales.x.ticks.map((tick) => tick.value) : [];
    const table = element("table", {}, element("thead", {}, element("tr", {}, element("th", {scope: "col"}, this.axes.x.title),
        ...ticks.map((tick) => element("th", {scope: "col"}, this.axes.x.form(tick))))));
    const body = element("tbody", {});
    for (const line of this.lines) {
      body.append(element("tr", {}, element("th", {scope: "row"}, line.label),
                          ...ticks.map((tick) => element("td", {}, this.answer(line, tick)))));
    }
    table.append(body);
    this.values.querySelector(".scroll").replaceChildren(table);
  }
}
