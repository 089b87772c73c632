// Which assets are shown, and in which order.

const FACETS = [
  { id: "status", title: "Status", values: a => [a.status] },
  { id: "change", title: "Changes", values: a => (a.change ? [a.change] : []), text: v => CHANGES[v] },
  { id: "warning", title: "Warnings", values: a => a.codes },
  { id: "error", title: "Errors", values: a => (a.error ? [a.error[0] || "other"] : []) },
  { id: "effect", title: "Effects", values: a => a.effects },
  { id: "format", title: "Format", values: a => (a.ending ? [a.ending] : []) },
  { id: "light", title: "Light", values: a => (a.light ? [a.light] : []) },
];

const known = value => value !== null && value !== undefined && !Number.isNaN(value);
const past = a => a.before && known(a.before.seconds) && a.wall[5] > 0 && a.before.seconds[0] > 0;

/** Ways to sort: a value (null: unknown, always last), whether large values come first, and the figure under a picture. */
const SORTS = [
  { id: "name", title: "Name", value: a => a.index, down: false,
    figure: a => [a.error ? a.error[0] : a.wall[5] > 0 && seconds(a.wall[5]), known(a.bound) && `error ≤ ${digits(a.bound)}`] },
  { id: "error", title: "Error", value: a => a.bound, down: true,
    figure: a => [known(a.bound) ? `error ≤ ${digits(a.bound)}` : "no error stated"] },
  { id: "time", title: "Time", value: a => (a.wall[5] > 0 ? a.wall[5] : null), down: true, figure: a => [seconds(a.wall[5])] },
  { id: "cpu", title: "CPU time", value: a => (a.cpu[5] > 0 ? a.cpu[5] : null), down: true, figure: a => [`${seconds(a.cpu[5])} of CPU`] },
  { id: "triangles", title: "Triangles", value: a => a.scene?.[0] ?? null, down: true,
    figure: a => [a.scene ? `${short(a.scene[0])} triangles` : "nothing read"] },
  { id: "samples", title: "Samples", value: a => largest([a.views?.spp ?? null].flat()), down: true,
    figure: a => [a.views ? `${short(largest([a.views.spp].flat()))} per pixel` : "no picture"] },
  { id: "warnings", title: "Warnings", value: a => a.warnings.length || null, down: true,
    figure: a => [a.warnings.length ? plural(a.warnings.length, "warning") : "no warning"] },
  { id: "memory", title: "Memory", value: a => a.peak ?? null, down: true, figure: a => [a.peak ? bytes(a.peak) : "not known"] },
  ...(data.against === null ? [] : [
    { id: "difference", title: "Difference", value: a => a.before?.levels ?? null, down: true, figure: a => [difference(a)] },
    { id: "slower", title: "Slower than before", value: a => (past(a) ? a.wall[5] / a.before.seconds[0] : null), down: true,
      figure: a => [past(a) ? `${digits(a.wall[5] / a.before.seconds[0])} × the time` : "not in both"] },
  ]),
];

const state = {
  query: "",
  chosen: new Map(FACETS.map(f => [f.id, new Set()])),
  sort: SORTS[0],
  down: SORTS[0].down,
  /** Assets shown, in order. */
  shown: assets,
  /** How many assets of each value would be shown, facet by facet. */
  counts: new Map(),
};

/** Finds what matches, counts what each filter would leave, and sorts. */
function select() {
  const words = fold(state.query).split(/\s+/).filter(Boolean);
  state.counts = new Map(FACETS.map(f => [f.id, new Map()]));
  const shown = [];
  for (const a of assets) {
    if (words.length && !words.every(word => haystack(a).includes(word))) continue;
    const misses = FACETS.filter(f => {
      const chosen = state.chosen.get(f.id);
      return chosen.size && !f.values(a).some(v => chosen.has(v));
    });
    if (misses.length === 0) shown.push(a);
    // A value is counted over what all the other filters leave.
    for (const facet of FACETS) {
      if (misses.length > 1 || (misses.length === 1 && misses[0] !== facet)) continue;
      const counts = state.counts.get(facet.id);
      for (const value of facet.values(a)) counts.set(value, (counts.get(value) ?? 0) + 1);
    }
  }
  const { value } = state.sort;
  const sign = state.down ? -1 : 1;
  const keys = new Map(shown.map(a => [a, value(a)]));
  shown.sort((a, b) => {
    const [x, y] = [keys.get(a), keys.get(b)];
    if (!known(x) || !known(y)) return known(y) - known(x) || a.index - b.index;
    return sign * (x - y) || a.index - b.index;
  });
  state.shown = shown;
}

/** Whether anything but the order is chosen. */
const isFiltered = () => state.query !== "" || [...state.chosen.values()].some(set => set.size > 0);

/** The choice as the part of the address after #. */
function choice() {
  const hash = new URLSearchParams();
  if (state.query) hash.set("q", state.query);
  for (const [id, set] of state.chosen) for (const value of set) hash.append(id, value);
  if (state.sort !== SORTS[0] || state.down !== SORTS[0].down) hash.set("sort", (state.down ? "-" : "") + state.sort.id);
  return hash;
}

/** Takes the choice from the address. */
function choose(hash) {
  state.query = hash.get("q") ?? "";
  for (const [id, set] of state.chosen) {
    set.clear();
    hash.getAll(id).forEach(value => set.add(value));
  }
  const [, minus, id] = (hash.get("sort") ?? "name").match(/^(-?)(.*)$/);
  state.sort = SORTS.find(s => s.id === id) ?? SORTS[0];
  state.down = minus === "-";
}
