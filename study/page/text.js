// Small helpers: elements, numbers as people read them, colours.

const $ = (id) => document.getElementById(id);

// An element with attributes and children; text goes in as text nodes, so nothing in the data is ever markup.
function element(name, attributes, ...children) {
  const node = document.createElement(name);
  for (const [key, value] of Object.entries(attributes || {})) node.setAttribute(key, value);
  node.append(...children.filter((child) => child !== null && child !== undefined));
  return node;
}

const kDash = "–";
const with_minus = (text) => text.replace(/^-/, "−");

function fixed(value, digits) {
  if (value === null || value === undefined) return kDash;
  if (Math.abs(value) >= 1e7) return with_minus(value.toExponential(3));
  const text = with_minus(value.toFixed(digits));
  return /[1-9]/.test(text) ? text : text.replace("−", "");
}

function count(value) { return value === null ? kDash : value.toLocaleString("en-US").replace(/,/g, "\u202f"); }

function duration(seconds) {
  if (seconds === null) return kDash;
  if (seconds < 1)
    return (seconds * 1e3)
               .toPrecision(seconds < 1e-3 ? 1 : 3)
               .replace(/\.?0+$/, (zeros) => zeros.startsWith(".") ? "" : zeros) +
        " ms";
  return seconds < 120 ? seconds.toFixed(seconds < 10 ? 2 : 1) + " s" : (seconds / 60).toFixed(1) + " min";
}

// A length that may be millimetres or metres.
function length(metres) {
  if (metres === null) return kDash;
  const size = Math.abs(metres);
  if (size >= 0.1) return fixed(metres, 3) + " m";
  if (size > 0 && size < 1e-6) return "< 0.001 mm";
  return String(parseFloat((metres * 1e3).toPrecision(3))).replace(/^-/, "−") + " mm";
}

function quantity(value, unit) {
  if (value === null) return kDash;
  return fixed(value, 3) + (unit === "rad" ? ` rad (${fixed((value * 180) / Math.PI, 0)}°)` : unit ? ` ${unit}` : "");
}

// Modules are blue to violet, obstacles coral, targets green, the path amber: told apart by hue at any brightness, and
// by lightness where hue is not seen.
const kModuleColours = ["#2f6fde", "#8a5be0", "#1699b8", "#c65a9f", "#4c58cf", "#5d86ab"];
const kColours = {
  base: "#59636f",
  joint: "#39414c",
  obstacle: "#e2694a",
  target: "#17a85b",
  path: "#eaa211",
  touch: "#c2123f"
};

const kAxisColours = ["#d8404c", "#3f9d4a", "#3a6fd8"];

// Module 0 is the base in most designs and has no body; the colours count from the first that has one.
function module_colour(index, first) {
  if (index < first) return kColours.base;
  return kModuleColours[(index - first) % kModuleColours.length];
}
