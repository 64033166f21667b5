// The side panel: what was found, in numbers.

function fill_panel(facts, module_hue, on_module) {
  $("problem").textContent = facts.problem || facts.title || "Solution";
  $("byline").textContent =
      [facts.solver && `Solved by ${facts.solver}`, facts.seed && `seed ${facts.seed}`].filter(Boolean).join(", ");
  $("score").textContent = fixed(facts.score, Math.abs(facts.score) < 10 ? 4 : 2);

  const badge = (kind, text) => $("badges").append(element("span", {class: `badge ${kind}`}, text));
  badge(facts.achieved ? "good" : "bad", facts.achieved ? "✓ achieved" : "✕ not achieved");
  if (facts.verified === "path")
    badge("good", "✓ verified by its path");
  else if (facts.verified && facts.verified !== "none")
    badge("good", `✓ verified: ${facts.verified}`);
  else
    badge("warn", "not verified");
  if (facts.reason) {
    $("reason").textContent = facts.reason;
    $("reason").hidden = false;
  }

  const numbers = [
    ["Modules", facts.modules.length ? String(facts.modules.length) : kDash],
    ["Mass", facts.mass === null ? kDash : `${fixed(facts.mass, 3)} kg`], ["Goal error", length(facts.goalError)],
    ["Clearance", length(facts.clearance)], ["Evaluations", count(facts.evaluations)], ["Time", duration(facts.seconds)]
  ];
  for (const [name, value] of numbers)
    $("numbers").append(element("div", {}, element("dt", {}, name), element("dd", {title: value}, value)));

  facts.modules.forEach((module, index) => {
    const swatch = element("span", {class: "swatch", "aria-hidden": "true"});
    swatch.style.background = module_hue(index);
    const parameters = module.parameters.map(
        (p) => element("span", {class: "parameter"}, element("i", {}, `${p.name} `), quantity(p.value, p.unit)));
    const row = element(
        "tr", {tabindex: "0"}, element("td", {}, String(index)), element("td", {}, swatch, module.type),
        element("td", {}, ...(parameters.length ? parameters : [element("span", {class: "muted"}, "none")])));
    for (const event of ["mouseenter", "focus"]) row.addEventListener(event, () => on_module(index));
    for (const event of ["mouseleave", "blur"]) row.addEventListener(event, () => on_module(null));
    $("design").tBodies[0].append(row);
  });

  fill_terms(facts);
  if (facts.command) {
    // A line may end between words only, never behind the hyphens of an option.
    facts.command.split(" ").forEach(
        (word, i) => $("command").append(i ? " " : "", element("span", {class: "word"}, word)));
    $("reproduce").hidden = false;
  }
}

// Each term with a bar from zero, all to one scale, so that the eye can add them up.
function fill_terms(facts) {
  const values = facts.terms.map((term) => term.value || 0);
  const low = Math.min(0, ...values), high = Math.max(0, ...values), span = high - low || 1;
  for (const term of facts.terms) {
    const bar = element("span", {class: term.value < 0 ? "loss" : "gain"});
    bar.style.left = `${(100 * (Math.min(0, term.value) - low)) / span}%`;
    bar.style.width = `${(100 * Math.abs(term.value)) / span}%`;
    $("terms").tBodies[0].append(element(
        "tr", {}, element("td", {}, term.name),
        element("td", {}, element("div", {class: "bar", "aria-hidden": "true"}, bar)),
        element("td", {}, fixed(term.value, 3))));
  }
  const sum = values.reduce((total, value) => total + value, 0);
  const off = facts.terms.length && facts.score !== null &&
      Math.abs(sum - facts.score) > 1e-6 * Math.max(1, Math.abs(facts.score));
  $("terms").tFoot.append(element(
      "tr", {}, element("td", {colspan: "2"}, off ? `score (the terms add up to ${fixed(sum, 3)})` : "score"),
      element("td", {}, fixed(facts.score, 3))));
}
