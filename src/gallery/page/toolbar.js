// Search, filters and sorting.

const search = find("search");
const sorting = find("sort");
const direction = find("direction");

/** Everything after a change of the choice. */
function update({ keepPlace = false } = {}) {
  select();
  if (!keepPlace) {
    focused = 0;
    const top = find("pictures").getBoundingClientRect().top - find("toolbar").offsetHeight;
    if (top < 0) scrollBy(0, top);
  }
  layout();
  chips();
  for (const facet of menus) facet.update();
  const count = state.shown.length;
  find("count").textContent = isFiltered() ? `${whole.format(count)} of ${plural(assets.length, "asset")}` : plural(assets.length, "asset");
  find("nothing").hidden = count > 0;
  sorting.value = state.sort.id;
  direction.textContent = state.down ? "↓" : "↑";
  direction.title = state.down ? "Largest first" : "Smallest first";
  direction.setAttribute("aria-label", `${direction.title}; turn round`);
  if (!dialog.open) {
    const hash = choice().toString();
    history.replaceState(null, "", hash ? `#${hash}` : location.pathname + location.search);
  }
}

function toggle(id, value) {
  const chosen = state.chosen.get(id);
  if (!chosen.delete(value)) chosen.add(value);
  update();
}

/** The statuses, with how many assets each has. */
const present = STATUSES.filter(status => assets.some(a => a.status === status));
const statusButtons = present.map(status => {
  const count = el("span", { class: "number" });
  const button = el("button", { type: "button", class: `status ${status}`, onclick: () => toggle("status", status) }, mark(status), el("span", { text: status }), count);
  find("statuses").append(button);
  return { status, button, count };
});

function chips() {
  const chosen = state.chosen.get("status");
  for (const { status, button, count } of statusButtons) {
    count.textContent = whole.format(state.counts.get("status").get(status) ?? 0);
    button.setAttribute("aria-pressed", String(chosen.has(status)));
  }
}

/** A menu of a filter's values. */
function menu(facet) {
  const values = new Map();
  for (const a of assets) for (const value of facet.values(a)) values.set(value, (values.get(value) ?? 0) + 1);
  // A filter that parts nothing from nothing is none.
  if (values.size === 0 || (values.size === 1 && [...values.values()][0] === assets.length)) return null;
  const text = facet.text ?? (value => value);
  const rows = [...values].sort((a, b) => b[1] - a[1]).map(([value]) => {
    const box = el("input", { type: "checkbox", onchange: () => toggle(facet.id, value) });
    const count = el("span", { class: "number" });
    return { value, box, count, node: el("label", {}, box, el("span", { text: text(value) }), count) };
  });
  const badge = el("span", { class: "badge" });
  const list = el("div", { class: "menu", role: "group", "aria-label": facet.title }, rows.map(r => r.node));
  const node = el("details", { class: "facet" }, el("summary", {}, facet.title, badge), list);
  node.addEventListener("toggle", () => {
    if (!node.open) return;
    // Within the window, whatever place the button has.
    list.style.left = "0";
    const over = list.getBoundingClientRect().right - (document.documentElement.clientWidth - 12);
    if (over > 0) list.style.left = `${-over}px`;
  });
  node.addEventListener("keydown", event => {
    if (event.key !== "Escape" || !node.open) return;
    node.open = false;
    node.querySelector("summary").focus();
  });
  find("facets").append(node);
  const update = () => {
    const chosen = state.chosen.get(facet.id);
    badge.textContent = chosen.size || "";
    for (const r of rows) {
      const count = state.counts.get(facet.id).get(r.value) ?? 0;
      r.count.textContent = whole.format(count);
      r.box.checked = chosen.has(r.value);
      r.node.classList.toggle("none", count === 0 && !r.box.checked);
    }
  };
  return { node, update };
}

const menus = FACETS.slice(1).map(menu).filter(Boolean);
addEventListener("pointerdown", event => {
  for (const { node } of menus) if (node.open && !node.contains(event.target)) node.open = false;
});
find("facets").addEventListener("focusout", event => {
  for (const { node } of menus) if (node.open && event.relatedTarget && !node.contains(event.relatedTarget)) node.open = false;
});

sorting.append(...SORTS.map(s => el("option", { value: s.id, text: s.title })));
sorting.addEventListener("change", () => {
  state.sort = SORTS.find(s => s.id === sorting.value);
  state.down = state.sort.down;
  update();
});
direction.addEventListener("click", () => { state.down = !state.down; update(); });

search.addEventListener("input", () => { state.query = search.value; update(); });
search.addEventListener("keydown", event => {
  if (event.key === "ArrowDown" || event.key === "Enter") {
    event.preventDefault();
    focus(0);
  }
});
addEventListener("keydown", event => {
  if (event.key !== "/" || dialog.open || event.target.matches("input, select") || event.ctrlKey || event.metaKey || event.altKey) return;
  event.preventDefault();
  search.select();
  search.focus();
});

find("clear").addEventListener("click", () => {
  state.query = search.value = "";
  for (const set of state.chosen.values()) set.clear();
  update();
  search.focus();
});

const sizing = find("size");
sizing.value = size.wanted;
sizing.addEventListener("input", () => {
  size.wanted = Number(sizing.value);
  memory.set("size", sizing.value);
  layout();
});
