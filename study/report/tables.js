// The tables of a report.

function table_into(id, head, rows) {
  const header = element("tr", {}, ...head.map(([text, title, kind]) => {
    const cell = element("th", {scope: "col", class: kind || ""}, text);
    if (title) cell.title = title;
    return cell;
  }));
  $(id).replaceChildren(element("thead", {}, header), element("tbody", {}, ...rows));
}

function solver_head(report, solver) {
  const dot = element("span", {class: "dot", "aria-hidden": "true"});
  dot.style.background = report.style(solver).colour;
  return element("th", {scope: "row", title: report.data.solvers[solver].solver}, dot, report.data.solvers[solver].label);
}

// A number with its interval in small print.
const with_interval = (text, interval, best) =>
    element("td", {class: best ? "best" : ""}, text, element("small", {}, interval));

const least_of = (values) => Math.min(...values.filter(is_number));

function fill_summary(report) {
  const {group, measure, target} = report.state();
  const regrets = least_of(group.rows.map((row) => row.regret[0]));
  const achieved = Math.max(...group.rows.map((row) => row.achieved[0]));
  const runtime = least_of(group.rows.map((row) => row[measure][target]));
  const head = [
    ["solver"], ["runs"], ["achieved", "share of runs that achieve the task, Wilson’s 95 % interval"],
    ["regret", "interquartile mean, 95 % bootstrap interval"],
    [`success: ${report.data.targets[target]}`, "share of runs, Wilson’s 95 % interval"],
    [`expected ${measure} to it`], ["evaluations and time of a run", "medians"]
  ];
  if (report.has_training) head.push(["training", "of one policy"]);
  table_into("summary", head, group.rows.map((row) => {
    const success = row.success[target];
    const cells = [
      solver_head(report, report.solver_of(row)),
      element("td", {}, count(row.runs), row.failed ? element("small", {}, `${row.failed} failed`) : null),
      with_interval(percent(row.achieved[0]), span(row.achieved, percent), row.achieved[0] === achieved),
      with_interval(brief(row.regret[0]), span(row.regret, brief), row.regret[0] === regrets),
      with_interval(percent(success[0]), span(success, percent), false),
      element("td", {class: row[measure][target] === runtime ? "best" : ""}, cost(row[measure][target], measure)),
      element("td", {}, brief(row.medianEvaluations), element("small", {}, duration(row.medianSeconds)))
    ];
    if (report.has_training) {
      const own = row.training;
      cells.push(element("td", {}, own ? cost(own[measure], measure) : kDash,
                         own ? element("small", {}, measure === "seconds" ? `${count(own.evaluations)} evaluations` : duration(own.seconds)) : null));
    }
    return element("tr", {}, ...cells);
  }));
  const {optimal, bounded, instances, unreachable} = group, open = instances - optimal - bounded;
  const parts = [];
  if (optimal) parts.push(`${optimal} of ${plural(instances, "instance")} certified optimal`);
  if (bounded) parts.push(`${bounded} of ${instances} bounded, the largest gap ${brief(group.largestGap)}`);
  if (open) parts.push(`${open} of ${plural(instances, "instance")} without a bound: regret is against the best score of this study`);
  if (unreachable) parts.push(`${unreachable} proved unreachable and left out`);
  $("certificates").textContent = parts.join("; ") + ".";
  $("summary-note").textContent = `Bold: the best of the column. Intervals are of 95 %; those of regret from ${count(report.data.resamples)} resamples within instances.`;
}

function fill_costs(report) {
  const {group, measure} = report.state();
  $("costs-note").textContent = `Expected ${measure}, and the share of runs that met the target. Bold: the least.`;
  const least = report.data.targets.map((_, target) => least_of(group.rows.map((row) => row[measure][target])));
  table_into("costs", [["solver"], ...report.data.targets.map((target) => [target])],
             group.rows.map((row) => element("tr", {}, solver_head(report, report.solver_of(row)),
                 ...row[measure].map((value, target) => element("td", {class: value === least[target] ? "best" : ""},
                     cost(value, measure), element("small", {}, percent(row.success[target][0])))))));
}

function fill_pairs(report) {
  const {group} = report.state();
  $("pairs-note").textContent = `Probability that a run of the row has less regret than one of the column, with its 95 % interval. Bold: Wilcoxon’s signed-rank test over ${group.pairs} has p < 0.05 after Holm’s correction for all ${plural(group.comparisons.length, "pair")}. Fewer than six ${group.pairs} never show that much.`;
  const known = new Map();
  for (const {first, second, improvement: [value, low, high], p, pairs} of group.comparisons) {
    known.set(`${first},${second}`, {share: [value, low, high], p, pairs});
    known.set(`${second},${first}`, {share: [1 - value, 1 - high, 1 - low], p, pairs});
  }
  table_into("pairs", [["less regret than"], ...group.rows.map((row) => [row.label])], group.rows.map((row, a) =>
    element("tr", {}, solver_head(report, report.solver_of(row)), ...group.rows.map((_, b) => {
      const pair = known.get(`${a},${b}`);
      if (!pair) return element("td", {}, kDash);
      const cell = with_interval(pair.share[0].toFixed(2), span(pair.share, (value) => value.toFixed(2)), pair.p < 0.05);
      cell.title = `p = ${brief(pair.p)}, ${pair.pairs} pairs that differ`;
      return cell;
    }))));
}

const kCertificates = {optimal: "optimal", bounded: "gap", unreachable: "unreachable", none: "no bound"};

function fill_instances(report) {
  const {group} = report.state();
  const rows = report.data.instances.filter((instance) => !group.name || instance.problem === group.name);
  const solvers = group.rows.map((row) => report.solver_of(row));
  const head = [["instance"], ["best score"], ["modules"], ["mass [kg]"], ["found first by", "", "text"], ["certificate", "", "text"],
                ["bound"], ["3-D", "the best design", "text"], ...solvers.map((solver) => [report.data.solvers[solver].label, "median regret"])];
  table_into("instances", head, rows.map((instance) => {
    const best = instance.best, least = least_of(solvers.map((solver) => instance.regrets[solver]));
    const tag = element("span", {class: `tag ${instance.certificate}`}, kCertificates[instance.certificate] +
        (instance.certificate === "bounded" ? ` ${brief(instance.gap)}` : ""));
    const link = instance.view ? element("a", {href: instance.view, title: `cell ${best.cell}`}, "view") : kDash;
    return element("tr", {}, element("th", {scope: "row"}, instance.name), element("td", {}, best ? fixed(best.score, 3) : kDash),
        element("td", {}, best ? best.modules : kDash), element("td", {}, best ? fixed(best.mass, 3) : kDash),
        element("td", {class: "text"}, best ? best.solver : kDash), element("td", {class: "text"}, tag),
        element("td", {}, is_number(instance.bound) ? fixed(instance.bound, 3) : kDash), element("td", {class: "text"}, link),
        ...solvers.map((solver) => {
          const value = instance.regrets[solver];
          return element("td", {class: value === least ? "best" : ""}, value === "none" ? kDash : brief(value));
        }));
  }));
}

function fill_failures(report) {
  const failures = report.data.failures;
  $("failures-section").hidden = !failures.length;
  table_into("failures", [["cell"], ["solver", "", "text"], ["instance", "", "text"], ["seed"], ["what happened", "", "text"]],
             failures.map((own) => element("tr", {}, element("th", {scope: "row"}, own.cell),
                 element("td", {class: "text"}, own.label), element("td", {class: "text"}, own.instance),
                 element("td", {}, own.seed), element("td", {class: "text wrap"}, own.what))));
}
