// The assets, from the data in the page.

const data = JSON.parse(document.getElementById("data").textContent);

/** Statuses from the one that needs a look most. */
const STATUSES = ["failed", "partial", "warned", "ok", "skipped", "gone"];
const STATUS_TEXT = {
  ok: "Every picture is there.",
  warned: "Every picture is there, but something was mended or left out.",
  partial: "Stopped before it was finished.",
  failed: "It could not be rendered.",
  skipped: "It was not begun.",
  gone: "Only the earlier run has it.",
};
const CHANGES = { changed: "changed", same: "the same", fixed: "works now", broken: "no longer works", none: "no picture in either", gone: "gone", new: "new" };

/** Files of views, as a list. */
function files(paths) {
  if (!paths) return [];
  if (Array.isArray(paths)) return paths;
  const name = index => paths.before + String(index).padStart(3, "0") + paths.after;
  return Array.from({ length: paths.count }, (_, index) => name(index));
}

/** The address of a file; names may hold any character. */
const address = path => path.split("/").map(encodeURIComponent).join("/");

const largest = values => values?.reduce((most, v) => (v !== null && v > (most ?? -1) ? v : most), null) ?? null;

function asset(raw, index) {
  const cut = raw.input.lastIndexOf("/") + 1;
  const name = raw.input.slice(cut);
  const dot = name.lastIndexOf(".");
  const codes = [...new Set((raw.warnings ?? []).map(([code]) => data.words[code]))];
  return {
    ...raw,
    index,
    name,
    folder: raw.input.slice(0, cut),
    ending: dot > 0 ? name.slice(dot + 1).toLowerCase() : "",
    codes,
    warnings: (raw.warnings ?? []).map(([code, place, message]) => ({ code: data.words[code], place, message: data.words[message] })),
    effects: (raw.effects ?? []).map(effect => data.words[effect]),
    bound: largest(raw.views?.bound),
    change: data.against === null ? null : (raw.before?.change ?? "new"),
    get pictures() { return files(raw.views?.png); },
    get denoised() { return files(raw.views?.denoised); },
    get earlier() { return files(raw.before?.png); },
    count: Array.isArray(raw.views?.png) ? raw.views.png.length : (raw.views?.png?.count ?? 0),
  };
}

const assets = data.assets.map(asset);
const byInput = new Map(assets.map(a => [a.input, a]));

const fold = text => text.normalize("NFKC").toLowerCase();

/** All that the search looks through, made when it is first needed. */
function haystack(a) {
  a.haystack ??= fold([a.input, a.status, a.light, ...a.codes, ...a.effects, ...(a.error ?? []),
    ...a.warnings.map(w => w.message), a.change && CHANGES[a.change]].filter(Boolean).join("\n"));
  return a.haystack;
}

/** An element with attributes (`text`: its text, `onclick`: what happens) and children. */
function el(tag, attributes = {}, ...children) {
  const node = document.createElement(tag);
  for (const [name, value] of Object.entries(attributes)) {
    if (value === null || value === undefined || value === false) continue;
    if (name === "text") node.textContent = value;
    else if (name.startsWith("on")) node.addEventListener(name.slice(2), value);
    else node.setAttribute(name, value === true ? "" : value);
  }
  node.append(...children.flat().filter(child => child !== null && child !== undefined && child !== false));
  return node;
}

const find = id => document.getElementById(id);

/** What is remembered between visits, where the browser lets a page from disk do so. */
const memory = {
  get(key) { try { return localStorage.getItem("kiln." + key); } catch { return null; } },
  set(key, value) { try { localStorage.setItem("kiln." + key, value); } catch { /* then not */ } },
};
