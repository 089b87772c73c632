// Figures as people read them.

const whole = new Intl.NumberFormat("en");

/** Three digits that count. */
function digits(value) {
  if (value === 0) return "0";
  const size = Math.abs(value);
  if (size >= 1000) return whole.format(Math.round(value));
  if (size < 0.001) return value.toExponential(1).replace("e-", " · 10⁻").replace(/\d+$/, n => [...n].map(d => "⁰¹²³⁴⁵⁶⁷⁸⁹"[d]).join(""));
  return String(Number(value.toPrecision(size < 10 ? 2 : 3)));
}

function seconds(value) {
  if (value < 0.0005) return "0 ms";
  if (value < 1) return `${Math.max(1, Math.round(value * 1000))} ms`;
  if (value < 60) return `${value.toPrecision(value < 10 ? 2 : 3)} s`;
  const minutes = Math.floor(value / 60);
  if (minutes < 60) return `${minutes} min ${Math.round(value % 60)} s`;
  return `${Math.floor(minutes / 60)} h ${minutes % 60} min`;
}

function short(value) {
  if (value < 1e4) return whole.format(value);
  const [size, unit] = value < 1e6 ? [1e3, "k"] : value < 1e9 ? [1e6, "M"] : [1e9, "G"];
  return `${Number((value / size).toPrecision(3))} ${unit}`;
}

const bytes = value => (value < 1 << 30 ? `${Math.round(value / (1 << 20))} MB` : `${(value / 2 ** 30).toPrecision(3)} GB`);

const plural = (count, word) => `${whole.format(count)} ${word}${count === 1 ? "" : "s"}`;

/** What became of a picture since the earlier run. */
function difference(a) {
  if (!a.before) return "new";
  if (a.before.change !== "changed") return CHANGES[a.before.change];
  return known(a.before.levels) ? `differs by ${digits(a.before.levels)}` : "differs in size";
}

/** A sign for each status, told apart by its shape. */
function mark(status) {
  const shapes = {
    ok: "M3 8.5 6.5 12 13 4.5",
    warned: "M8 2.5 14 13.5H2ZM8 6.5v3.2M8 11.7v.1",
    partial: "M8 2a6 6 0 1 0 0 12ZM8 2a6 6 0 0 1 0 12",
    failed: "M4 4l8 8M12 4l-8 8",
    skipped: "M3.5 8h9",
    gone: "M3.5 8h9",
  };
  const svg = document.createElementNS("http://www.w3.org/2000/svg", "svg");
  svg.setAttribute("viewBox", "0 0 16 16");
  svg.setAttribute("aria-hidden", "true");
  svg.setAttribute("class", `mark ${status}`);
  const path = document.createElementNS("http://www.w3.org/2000/svg", "path");
  path.setAttribute("d", shapes[status] ?? shapes.skipped);
  svg.append(path);
  return svg;
}
