// Puts the report together and keeps it as the controls say.

const data = JSON.parse($("data").textContent);

class Report {
  constructor() {
    this.data = data;
    this.hidden = new Set();
    this.has_training = data.solvers.some((solver) => solver.trained);
    this.labels = new Map(data.solvers.map((solver, i) => [solver.label, i]));
  }
  state() {
    const group = data.groups[$("group").value];
    return {group, target: Number($("target").value), measure: $("measure").value, charging: $("charging").value};
  }
  solver_of(row) { return this.labels.get(row.label); }
  style(solver) { return {label: data.solvers[solver].label, colour: colour_of(solver), dash: dash_of(solver)}; }
  // Solvers that are drawn: those that have runs in the group and are not switched off.
  shown() {
    return this.state().group.rows.map((row) => this.solver_of(row)).filter((solver) => !this.hidden.has(solver));
  }
}
const report = new Report();

function option(value, text) { return element("option", {value}, text); }

function fill_controls() {
  $("group").append(...data.groups.map((group, i) => option(i, group.name || "all problems")));
  $("group").parentElement.hidden = data.groups.length < 2;
  $("target").append(...data.targets.map((target, i) => option(i, target)));
  $("charging-label").hidden = !report.has_training;
  const asked = new URLSearchParams(location.hash.slice(1));
  if (data.groups[asked.get("problem")]) $("group").value = asked.get("problem");
  if (kTitles[asked.get("measure")]) $("measure").value = asked.get("measure");
  $("target").value = report.state().group.target;
}

function fill_legend() {
  $("legend").replaceChildren(...data.solvers.map((solver, i) => {
    const {colour, dash} = report.style(i);
    const line = document.createElementNS("http://www.w3.org/2000/svg", "svg");
    line.setAttribute("viewBox", "0 0 26 10");
    line.setAttribute("aria-hidden", "true");
    const stroke = document.createElementNS("http://www.w3.org/2000/svg", "path");
    for (const [key, value] of [["d", "M0 5h26"], ["stroke", colour], ["stroke-width", 3], ["stroke-dasharray", dash.join(" ")]])
      stroke.setAttribute(key, value);
    line.append(stroke);
    const button = element("button", {type: "button", "aria-pressed": String(!report.hidden.has(i)), title: solver.solver},
                           line, solver.label + (solver.trained ? " (trained)" : ""));
    button.addEventListener("click", () => {
      if (!report.hidden.delete(i)) report.hidden.add(i);
      button.setAttribute("aria-pressed", String(!report.hidden.has(i)));
      draw_figures();
    });
    return element("li", {}, button);
  }));
}

// What the summary says in a sentence or two.
function finding() {
  const {group, target, measure} = report.state(), rows = group.rows.filter((row) => is_number(row.regret[0]));
  if (!rows.length) return "No solver achieved the task in three quarters of its runs.";
  const best = rows.reduce((a, b) => (b.regret[0] < a.regret[0] ? b : a));
  const equals = rows.filter((row) => row !== best && row.regret[1] <= best.regret[2]).map((row) => row.label);
  let text = `${best.label} has the least regret: ${brief(best.regret[0])} ${span(best.regret, brief)}` +
      (equals.length ? `; the ${equals.length === 1 ? "interval of" : "intervals of"} ${equals.join(", ")} overlap${equals.length === 1 ? "s" : ""} it.` : ".");
  if (report.has_training) {
    const points = group.breakEven[measure][target].filter(
        (point) => is_number(point.tasks) && group.rows[point.trained].success[target][0] >= kCompared);
    const name = data.targets[target];
    if (!points.length) text += ` At the target “${name}” no training pays, after however many tasks.`;
    else {
      // Against the cheapest solver that is not trained: the one that has to be beaten.
      const trained = group.rows.filter((row) => !row.training), cheapest = least_of(trained.map((row) => row[measure][target]));
      const honest = points.filter((point) => group.rows[point.classical][measure][target] === cheapest);
      if (!honest.length) text += ` At the target “${name}” training pays against some solvers, but not against the cheapest.`;
      else {
        const first = honest.reduce((a, b) => (b.tasks < a.tasks ? b : a));
        const [trained, other] = [first.trained, first.classical].map((row) => group.rows[row]);
        const met = (row) => `met in ${percent(row.success[target][0])} of its runs`;
        text += ` At the target “${name}” ${trained.label} (${met(trained)}) pays from ${plural(Math.max(1, Math.ceil(first.tasks)), "task")} on against the cheapest other solver, ${other.label} (${met(other)}).`;
      }
    }
  }
  return text;
}

function fill_frame() {
  const {study} = data;
  $("title").textContent = study.name;
  const budget = [];
  if (study.evaluations > 0) budget.push(plural(study.evaluations, "evaluation"));
  if (is_number(study.seconds)) budget.push(duration(study.seconds));
  const setting = [plural(data.solvers.length, "solver"), plural(data.instances.length, "instance"), plural(study.seeds, "seed"),
                   `at most ${budget.join(" and ")} a run`];
  if (study.done + study.failed < study.cells) setting.push(`unfinished: ${count(study.done)} of ${plural(study.cells, "cell")} are done`);
  if (study.failed) setting.push(`${study.failed} failed`);
  $("setting").textContent = setting.join(" · ");
  $("command").textContent = study.command || "(made by a program)";
  const facts = [["modsearch", study.version], ["compiler", study.compiler], ["instruction set of networks", study.instructionSet],
                 ["study", study.hash], ["cells", `${count(study.done)} of ${count(study.cells)} done`],
                 ["repeatable", study.timed ? "apart from runs that a clock ended" : "yes, apart from clock readings"]];
  $("facts").append(...facts.map(([name, value]) => element("div", {}, element("dt", {}, name), element("dd", {}, value || kDash))));
}

const draw_figures = make_figures(report, $("figures"));

function draw() {
  $("finding").textContent = finding();
  fill_summary(report);
  fill_costs(report);
  fill_pairs(report);
  fill_instances(report);
  draw_figures();
}

function restyle() {
  const dark = document.documentElement.dataset.theme === "dark";
  $("theme").textContent = dark ? "Light" : "Dark";
  fill_legend();
  draw();
}

Chart.defaults.font.family = getComputedStyle(document.body).fontFamily;
fill_controls();
fill_frame();
fill_failures(report);
restyle();
for (const id of ["target", "measure", "charging"]) $(id).addEventListener("change", draw);
$("group").addEventListener("change", () => {
  $("target").value = report.state().group.target;
  draw();
});
$("theme").addEventListener("click", () => {
  const root = document.documentElement;
  root.dataset.theme = root.dataset.theme === "dark" ? "light" : "dark";
  root.dataset.chosen = "yes";
  restyle();
});
addEventListener("themechange", restyle);
window.reportReady = true;
