// The figures of a report, each a function of the state: which group, target, measure, charging, and solvers.

const kTitles = {evaluations: "evaluations", seconds: "seconds"};
const share_axis = () => ({title: "share", min: 0, max: 1, form: percent});
const cost_axis = (measure) => ({title: kTitles[measure], log: true, form: (value) => cost(value, measure)});

// Line of a solver from a step function that holds its value to `end`.
function stepped_line(report, solver, steps, end) {
  const x = [...steps.x], y = [...steps.y];
  if (x.length) {
    // From nothing up to the first step, and on to the end of the axis.
    x.unshift(x[0]);
    y.unshift(0);
    if (x[x.length - 1] < end) {
      x.push(end);
      y.push(y[y.length - 1]);
    }
  }
  return {...report.style(solver), x, y, stepped: true, absent: percent(0)};
}

function show_steps(report, figure, functions, options) {
  const shown = report.shown().filter((solver) => functions[solver]);
  const ends = shown.flatMap((solver) => functions[solver].x.slice(-1)), end = Math.max(...ends, options.least || 0);
  const lines = shown.map((solver) => stepped_line(report, solver, functions[solver], end * 1.15));
  figure.show({...options, lines, y: {...share_axis(), title: options.share}});
}

function show_runtimes(report, figure, measure) {
  const {group, charging} = report.state();
  const charged = report.has_training ? (charging === "use" ? " Training is charged apart." : " Training is charged to every run.") : "";
  show_steps(report, figure, group.curves[measure][charging], {
    note: `Share of (instance, seed, target) triples met within a cost: all ${report.data.targets.length} targets together.` + charged,
    share: "triples met",
    x: cost_axis(measure)
  });
}

// Regret below this is drawn here: a logarithmic axis has no 0.
const kLeastRegret = 1e-4;

function show_convergence(report, figure) {
  const {group, measure} = report.state();
  const curves = group.curves[measure].convergence, visible = report.shown().map((solver) => curves[solver]);
  const end = Math.max(...visible.flatMap((curve) => curve.x.slice(-1)));
  const all = visible.flatMap((curve) => [...curve.y, ...curve.high]).filter(is_number);
  const top = Math.max(kLeastRegret * 10, ...all) * 1.5;
  const drawn = (value) => (is_number(value) ? Math.max(kLeastRegret, value) : null);
  const lines = report.shown().map((solver) => {
    const curve = curves[solver], last = (values) => [...values, values[values.length - 1]];
    return {
      ...report.style(solver),
      stepped: true,
      // A run that has ended keeps its result, so that every line goes on to the end of the longest.
      x: [...curve.x, end],
      y: last(curve.y).map(drawn),
      // Where the lower quarter has achieved the task and the upper has not, the band is open to the top.
      low: last(curve.low).map(drawn),
      high: last(curve.high).map((value, i) => (is_number(value) ? drawn(value) : is_number(last(curve.low)[i]) ? top : null)),
      absent: kNever
    };
  });
  figure.show({
    note: "Regret of the best design so far: median and quartiles of all runs of all instances. A median is there once half of the runs have achieved the task.",
    nothing: "No solver achieved the task in half of its runs.",
    lines,
    x: cost_axis(measure),
    y: {title: "regret", log: true, max: top, form: (value) => (value <= kLeastRegret ? `≤ ${kLeastRegret}` : brief(value))}
  });
}

function show_performance(report, figure) {
  const {group, measure, target} = report.state();
  show_steps(report, figure, group.curves[measure].performance[target], {
    note: `Share of (instance, seed) pairs solved within a factor of the best solver’s ${kTitles[measure]}. Target: ${report.data.targets[target]}.`,
    share: "pairs solved",
    least: 10,
    x: {title: "factor of the best", log: true, min: 1, form: brief}
  });
}

function show_data_profile(report, figure) {
  const {group, target} = report.state();
  show_steps(report, figure, group.dataProfile[target], {
    note: `Share of (instance, seed) pairs solved within a number of simplex gradients: evaluations / (dimension + 1). Target: ${report.data.targets[target]}.`,
    share: "pairs solved",
    x: {title: "simplex gradients", log: true, form: brief}
  });
}

// A policy that misses a target misses it again: where it meets it in fewer of its runs, restarts say nothing.
const kCompared = 0.5;

function show_amortisation(report, figure) {
  const {group, measure, target} = report.state();
  const points = group.breakEven[measure][target].filter((point) => is_number(point.tasks) && point.tasks >= 1);
  const last = Math.max(1e4, ...points.map((point) => 10 * point.tasks)), x = [], marks = [];
  for (let i = 0; i <= 80; ++i) x.push(last ** (i / 80));
  const visible = new Set(report.shown());
  const per_task = (row) => {
    const use = row[measure][target];
    if (!is_number(use)) return null;
    return row.training ? (tasks) => row.training[measure] / tasks + use : () => use;
  };
  const lines = [];
  for (const row of group.rows) {
    const solver = report.solver_of(row), of = per_task(row);
    if (visible.has(solver) && of) lines.push({...report.style(solver), x, y: x.map(of), read: of});
  }
  const costs = group.rows.filter((row) => !row.training && visible.has(report.solver_of(row))).map((row) => row[measure][target]);
  const least = Math.min(...costs.filter(is_number));
  for (const point of points) {
    const trained = group.rows[point.trained], classical = group.rows[point.classical];
    if (trained.success[target][0] < kCompared) continue;
    if (!visible.has(report.solver_of(trained)) || !visible.has(report.solver_of(classical))) continue;
    marks.push({x: point.tasks, y: classical[measure][target], colour: report.style(report.solver_of(trained)).colour,
                // A name for the one that has to be beaten; all would not find room.
                text: classical[measure][target] === least ? `${brief(Math.ceil(point.tasks))} tasks` : ""});
  }
  const trained_lines = group.rows.some((row) => row.training && per_task(row));
  const outcome = !report.has_training ? "No solver of this study is trained." :
      !trained_lines ? "No trained solver meets this target." :
      marks.length ? "Rings: break-even, with the number of tasks against the cheapest other solver." : "No trained solver breaks even against another at this target.";
  figure.show({
    note: `Cost per task where the training is shared by N tasks; N = 1 charges all of it to one instance. Target: ${report.data.targets[target]}. ${outcome}`,
    lines,
    marks,
    x: {title: "tasks N", log: true, min: 1, max: last, form: (value) => brief(Math.round(value))},
    y: {...cost_axis(measure), title: `${kTitles[measure]} per task`}
  });
}

function make_figures(report, host) {
  const figures = [
    ["Runtimes in evaluations", (figure) => show_runtimes(report, figure, "evaluations")],
    ["Runtimes in seconds", (figure) => show_runtimes(report, figure, "seconds")],
    ["Convergence", (figure) => show_convergence(report, figure)],
    ["What learning costs per task", (figure) => show_amortisation(report, figure)],
    ["Performance profile", (figure) => show_performance(report, figure)],
    ["Data profile", (figure) => show_data_profile(report, figure)]
  ].map(([title, show]) => ({figure: new Figure(host, title), show}));
  return () => figures.forEach(({figure, show}) => show(figure));
}
