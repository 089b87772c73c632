// The wall of pictures: only the cards near the window exist.

const grid = find("grid");
const GAP = 22;
const CAPTION = 52;
/** Screens above and below the window that are kept ready. */
const OVERSCAN = 0.6;

const size = { wanted: Number(memory.get("size")) || 196, columns: 1, cell: 196, stage: 196, row: 270 };
/** Cards by their place in the order, and cards to be used again. */
const cards = new Map();
const spare = [];
let focused = 0;

/** Height by width of the pictures: the first asset's stands for all. */
const aspect = (() => {
  const views = assets.find(a => a.views)?.views;
  return views ? Math.min(1.4, Math.max(0.5, views.height / views.width)) : 1;
})();

class Card {
  constructor() {
    this.picture = el("img", { alt: "", decoding: "async", draggable: "false" });
    this.text = el("span", { class: "instead" });
    this.angle = el("span", { class: "angle" });
    this.stage = el("span", { class: "stage" }, this.picture, this.text, this.angle);
    this.name = el("span", { class: "name" });
    this.figure = el("span", { class: "figure" });
    this.link = el("a", { class: "open", draggable: "false" }, this.stage, this.name, this.figure);
    this.node = el("li", { class: "card" }, this.link);
    this.turntable = new Turntable(this.stage, this.picture, k => this.angle.style.setProperty("--at", k / this.turntable.addresses.length));
    this.picture.addEventListener("load", () => this.node.classList.add("loaded"));
    this.picture.addEventListener("error", () => this.instead("The picture is not there."));
    this.link.addEventListener("click", event => {
      const dragged = this.turntable.moved && event.pointerType === "touch";
      this.turntable.moved = false;
      if (event.metaKey || event.ctrlKey || event.shiftKey) return;
      event.preventDefault();
      if (!dragged) open(this.asset);
    });
    this.link.addEventListener("focus", () => { focused = this.place; });
  }

  instead(text) {
    this.text.textContent = text;
    this.node.classList.toggle("blank", text !== "");
  }

  show(a, place) {
    if (this.asset !== a) {
      this.asset = a;
      this.node.className = `card ${a.status}`;
      this.link.href = `#asset=${encodeURIComponent(a.input)}`;
      this.link.title = a.input;
      this.name.replaceChildren(a.status === "ok" ? "" : mark(a.status), el("bdi", { text: a.name }));
      this.pictures(a);
    }
    this.figure.textContent = state.sort.figure(a).filter(Boolean).join(" · ") || a.error?.[0] || a.status;
    this.link.setAttribute("aria-label", [a.input, a.status, this.figure.textContent, a.count > 1 && `${a.count} views`].filter(Boolean).join(", "));
    this.link.tabIndex = place === focused ? 0 : -1;
    this.place = place;
    this.node.setAttribute("aria-setsize", state.shown.length);
    this.node.setAttribute("aria-posinset", place + 1);
    const column = place % size.columns;
    const line = Math.floor(place / size.columns);
    this.node.style.transform = `translate(${column * (size.cell + GAP)}px, ${line * size.row}px)`;
    this.node.style.width = `${size.cell}px`;
  }

  pictures(a) {
    const addresses = (a.count ? a.pictures : a.earlier).map(address);
    this.turntable.set(addresses);
    this.node.classList.toggle("turns", addresses.length > 1);
    this.node.classList.toggle("tint", a.status === "gone");
    if (addresses.length) {
      this.instead("");
      this.picture.src = addresses[0];
      if (this.picture.complete && this.picture.naturalWidth) this.node.classList.add("loaded");
    } else {
      this.picture.removeAttribute("src");
      this.instead(a.error?.[1] ?? (a.views ? "EXR only" : STATUS_TEXT[a.status] ?? a.status));
    }
  }

  /** Makes it ready to be used for another asset; what it was loading is not needed any more. */
  clear() {
    this.turntable.set([]);
    this.picture.removeAttribute("src");
    this.asset = null;
    this.node.remove();
  }
}

/** Computes the measures of the wall for the window's width. */
function layout() {
  const width = grid.clientWidth;
  const narrow = width < 520;
  const gap = GAP;
  const least = narrow ? Math.min(size.wanted, (width - gap) / 2) : size.wanted;
  size.columns = Math.max(1, Math.floor((width + gap) / (least + gap)));
  const cell = (width - gap * (size.columns - 1)) / size.columns;
  size.cell = Math.floor(state.shown.length < size.columns ? Math.min(cell, size.wanted * 1.25) : cell);
  size.stage = Math.round(size.cell * aspect);
  size.row = size.stage + CAPTION + GAP;
  grid.style.setProperty("--height", `${size.stage}px`);
  grid.style.height = `${Math.ceil(state.shown.length / size.columns) * size.row}px`;
  draw();
}

/** Shows the cards near the window. */
function draw() {
  const top = -grid.getBoundingClientRect().top;
  const margin = innerHeight * OVERSCAN;
  const line = y => Math.floor(y / size.row);
  const begin = Math.max(0, line(top - margin)) * size.columns;
  const end = Math.min(state.shown.length, (line(top + innerHeight + margin) + 1) * size.columns);
  const wanted = place => (place >= begin && place < end) || place === focused;
  for (const [place, card] of cards) {
    if (wanted(place) && card.asset === state.shown[place]) continue;
    cards.delete(place);
    card.clear();
    spare.push(card);
  }
  const places = [];
  for (let place = begin; place < end; place += 1) places.push(place);
  if (focused < state.shown.length && (focused < begin || focused >= end)) places.push(focused);
  for (const place of places) {
    const card = cards.get(place) ?? spare.pop() ?? new Card();
    card.show(state.shown[place], place);
    if (cards.get(place) !== card) {
      cards.set(place, card);
      // In the order of the assets, which is that of reading.
      const next = [...grid.children].find(node => Number(node.getAttribute("aria-posinset")) > place + 1);
      grid.insertBefore(card.node, next ?? null);
    }
  }
}

/** Moves the focus to a place in the order, and the window there. */
function focus(place) {
  focused = Math.max(0, Math.min(state.shown.length - 1, place));
  const y = grid.getBoundingClientRect().top + Math.floor(focused / size.columns) * size.row;
  const above = find("toolbar").offsetHeight + 12;
  if (y < above) scrollBy(0, y - above);
  else if (y + size.row > innerHeight) scrollBy(0, y + size.row - innerHeight);
  draw();
  for (const card of cards.values()) card.link.tabIndex = card.place === focused ? 0 : -1;
  cards.get(focused)?.link.focus({ preventScroll: true });
}

grid.addEventListener("keydown", event => {
  if (event.altKey || event.ctrlKey || event.metaKey) return;
  const screen = Math.max(1, Math.floor(innerHeight / size.row)) * size.columns;
  const rtl = getComputedStyle(grid).direction === "rtl" ? -1 : 1;
  const step = { ArrowLeft: -rtl, ArrowRight: rtl, ArrowUp: -size.columns, ArrowDown: size.columns, PageUp: -screen, PageDown: screen, Home: -Infinity, End: Infinity }[event.key];
  if (step === undefined) return;
  event.preventDefault();
  focus(focused + step);
});

let drawing = false;
addEventListener("scroll", () => {
  if (drawing) return;
  drawing = true;
  requestAnimationFrame(() => { drawing = false; draw(); });
}, { passive: true });
new ResizeObserver(() => layout()).observe(grid);
