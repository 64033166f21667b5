// Solvers as lines: their colours, their values along an axis, and numbers as people read them.

// Okabe and Ito (2008): told apart with any kind of colour vision. The darkest first, so that two or three solvers have
// the most contrast; after eight the colours come again with dashes. Ink stands for their black.
const kPalette = ["#0072b2", "#d55e00", "#009e73", "#cc79a7", "#e69f00", "#56b4e9", "ink", "#b8a800"];
const kDashes = [[], [7, 4], [2, 3]];

const css = (name) => getComputedStyle(document.documentElement).getPropertyValue(name).trim();

function colour_of(solver) {
  const colour = kPalette[solver % kPalette.length];
  if (colour === "ink") return css("--ink");
  // On dark ground the deep blue is too close to it, and a lighter one to sky blue: it becomes violet.
  return colour === "#0072b2" && document.documentElement.dataset.theme === "dark" ? "#6d84ff" : colour;
}
const dash_of = (solver) => kDashes[Math.floor(solver / kPalette.length) % kDashes.length];

const translucent = (hex, share) => hex + Math.round(255 * share).toString(16).padStart(2, "0");

// The value of a step function {x, y} at `at`: that of the last x not beyond it, null before the first.
function value_at(steps, at) {
  let low = 0, high = steps.x.length;
  while (low < high) {
    const middle = (low + high) >> 1;
    if (steps.x[middle] <= at) low = middle + 1;
    else high = middle;
  }
  return low ? steps.y[low - 1] : null;
}

const kNever = "∞";
const is_number = (value) => typeof value === "number";

// Three digits, without an exponent where it can be avoided; null is infinite.
function brief(value) {
  if (!is_number(value)) return kNever;
  const size = Math.abs(value);
  if (size === 0) return "0";
  if (size >= 1e7 || size < 1e-4) return with_minus(value.toExponential(1).replace("e+", "e"));
  if (size >= 1000) return count(Math.round(value));
  return with_minus(String(Number(value.toPrecision(3))));
}
const percent = (share) => `${(100 * share).toFixed(share > 0 && share < 0.1 ? 1 : 0)} %`;
const cost = (value, measure) => (measure === "seconds" && is_number(value) ? duration(value) : brief(value));
const span = ([, low, high], form) => `[${form(low)}, ${form(high)}]`;
const plural = (n, noun) => `${count(n)} ${noun}${n === 1 ? "" : "s"}`;
