// One asset: its pictures large, beside the earlier run's, and every figure.

const dialog = find("details");
const STAGES = ["Import", "Prepare", "kd-tree", "Render", "Write"];
const MODES = [["now", "Now"], ["split", "Slider"], ["earlier", "Earlier"], ["difference", "Difference × 8"]];
let current = null;
let mode = "split";

const row = (term, value, note) => (value === null || value === undefined || value === "" ? null
  : el("div", {}, el("dt", { text: term }), el("dd", {}, ...[value].flat(), note && el("small", { text: note }))));
const section = (title, ...content) => (content.flat().some(Boolean) ? el("section", {}, el("h3", { text: title }), ...content) : null);
const list = (...rows) => (rows.some(Boolean) ? el("dl", {}, ...rows) : null);

/** The pictures, with what turns and compares them. */
function pictures(a) {
  const now = a.pictures.map(address);
  const earlier = a.earlier.map(address);
  const compares = now.length > 0 && earlier.length > 0;
  const shown = now.length ? now : earlier;
  if (!shown.length) {
    return el("div", { class: "scene" }, el("div", { class: "easel empty" }, el("p", { text: a.views ? "This asset has EXR files only." : "There is no picture." })));
  }
  const picture = el("img", { class: "now", src: shown[0], alt: `${a.name}${now.length ? "" : ", as the earlier run made it"}`, draggable: "false" });
  const past = compares && el("img", { class: "earlier", src: earlier[0], alt: `${a.name}, earlier`, draggable: "false" });
  const easel = el("div", { class: "easel" }, picture, past);
  if (a.views) {
    easel.style.setProperty("--ratio", a.views.width / a.views.height);
    // Small pictures are shown as they are, not blown up without bounds.
    easel.style.setProperty("--width", Math.max(a.views.width, 384));
  }
  const controls = el("div", { class: "controls" });
  if (shown.length > 1) controls.append(turner(a, easel, picture, past, shown, earlier));
  if (compares) controls.append(comparer(a, easel));
  if (!compares && shown.length === 1 && a.denoised.length === 1) controls.append(denoiser(picture, shown[0], address(a.denoised[0])));
  controls.append(backdrop(easel));
  return el("div", { class: "scene" }, easel, controls);
}

/** A slider that turns the turntable, beside dragging. */
function turner(a, easel, picture, past, shown, earlier) {
  const slider = el("input", { type: "range", min: 0, max: shown.length - 1, value: 0, "aria-label": "View" });
  const label = el("output", { text: `1 / ${shown.length}` });
  const turntable = new Turntable(easel, picture, index => {
    slider.value = index;
    label.textContent = `${index + 1} / ${shown.length}`;
    if (past) past.src = earlier[Math.min(index, earlier.length - 1)];
    const figures = find("accuracy");
    if (figures) figures.replaceWith(accuracy(a, index));
  });
  Object.assign(turntable, { dragOnly: true, keeps: true });
  turntable.set(shown);
  slider.addEventListener("input", () => { turntable.load(); turntable.show(Number(slider.value)); });
  easel.classList.add("turns");
  easel.addEventListener("pointerdown", event => { if (event.target !== easel.querySelector(".wipe")) easel.setPointerCapture(event.pointerId); });
  if (a.before?.view) queueMicrotask(() => { turntable.load(); turntable.show(a.before.view); });
  return el("label", { class: "turner" }, el("span", { text: "View" }), slider, label);
}

/** Now, earlier, a slider between them, or what differs. */
function comparer(a, easel) {
  const wipe = el("input", { class: "wipe", type: "range", min: 0, max: 100, step: 0.5, value: 50, "aria-label": "How much of the earlier picture" });
  const place = () => easel.style.setProperty("--wipe", `${wipe.value}%`);
  wipe.addEventListener("input", place);
  easel.append(el("span", { class: "seam" }), el("span", { class: "tag left", text: "earlier" }), el("span", { class: "tag right", text: "now" }), wipe);
  place();
  const buttons = MODES.map(([id, text]) => el("button", { type: "button", text, "data-mode": id, onclick: () => set(id) }));
  const set = id => {
    mode = id;
    easel.dataset.mode = id;
    buttons.forEach(b => b.setAttribute("aria-pressed", String(b.dataset.mode === id)));
  };
  set(mode);
  return el("div", { class: "segments", role: "group", "aria-label": "Compare with the earlier run" }, buttons);
}

/** The picture as it was rendered, whose error is known, or the one without noise. */
function denoiser(picture, rendered, denoised) {
  const set = (button, source) => {
    picture.src = source;
    buttons.forEach(b => b.setAttribute("aria-pressed", String(b === button)));
  };
  const buttons = [["As rendered", rendered], ["Denoised", denoised]].map(([text, source]) => {
    const button = el("button", { type: "button", text, onclick: () => set(button, source) });
    return button;
  });
  set(buttons[0], rendered);
  return el("div", { class: "segments", role: "group", "aria-label": "Noise" }, buttons);
}

/** What lies behind what is transparent. */
function backdrop(easel) {
  const kinds = [["", "Plain"], ["white", "White"], ["black", "Black"], ["checks", "Checks"]];
  const choice = el("select", { "aria-label": "Background" }, kinds.map(([value, text]) => el("option", { value, text })));
  choice.value = memory.get("backdrop") ?? "";
  const set = () => { easel.dataset.backdrop = choice.value; memory.set("backdrop", choice.value); };
  choice.addEventListener("change", set);
  set();
  return el("label", { class: "backdrop" }, el("span", { text: "Background" }), choice);
}

function accuracy(a, view) {
  const views = a.views;
  const at = values => (Array.isArray(values) ? values[view] : values) ?? null;
  const [error, bound, relmse] = [at(views.error), at(views.bound), at(views.relmse)];
  const met = views.met === undefined ? "" : views.met ? "The error asked for is reached." : "The error asked for is not reached.";
  const range = a.count > 1 && known(a.bound) ? `at most ${digits(a.bound)} over all ${a.count} views` : "";
  return el("div", { id: "accuracy" }, list(
    row("Error", known(error) ? `${digits(error)} levels of 255` : "not stated", known(bound) ? `at most ${digits(bound)}, with 95 % confidence${range && "; " + range}` : ""),
    row("relMSE", known(relmse) ? digits(relmse) : null, "in linear light"),
    row("Samples", `${whole.format(at(views.spp))} per pixel`, `${views.width} × ${views.height} pixels${views.exposure ? `, exposure ${digits(views.exposure)} EV` : ""}`),
    row("Bias", views.bias?.join("; ")),
  ), met && el("p", { class: views.met ? "note" : "note late", text: met }));
}

/** Where the time went, as a bar and as a table. */
function times(a) {
  const total = a.wall.slice(0, 5).reduce((sum, s) => sum + s, 0);
  if (!(total > 0)) return null;
  const bar = el("div", { class: "bar", "aria-hidden": "true" }, STAGES.map((_, i) => {
    const part = el("span", { class: `stage-${i}` });
    part.style.flexGrow = a.wall[i] / total;
    return part;
  }));
  const cells = (i, name) => el("tr", {}, el("th", { scope: "row" }, i < 5 && el("i", { class: `stage-${i}` }), name), el("td", { text: seconds(a.wall[i]) }), el("td", { text: seconds(a.cpu[i]) }));
  const head = el("tr", {}, el("th", { scope: "col", text: "Stage" }), el("th", { scope: "col", text: "Wall" }), el("th", { scope: "col", text: "CPU" }));
  return [bar, el("table", {}, el("thead", {}, head), el("tbody", {}, STAGES.map((name, i) => cells(i, name)), cells(5, "In all")))];
}

function compared(a) {
  const was = a.before;
  if (!was) return data.against === null ? null : el("p", { class: "note", text: `${data.against} does not have it.` });
  const time = was.seconds[0] > 0 ? seconds(was.seconds[0]) : null;
  const ratio = past(a) ? `now ${digits(a.wall[5] / was.seconds[0])} × that` : "";
  return list(
    row("Pictures", difference(a), known(was.levels) ? `RMS levels of 255${a.count > 1 ? `, in view ${was.view + 1}` : ""}` : ""),
    row("Status then", was.status),
    row("Time then", time, ratio),
    row("Error then", was.error ? `${digits(was.error[0])} levels` : null, was.error ? `at most ${digits(was.error[1])}` : ""),
  );
}

function warnings(a) {
  if (!a.warnings.length) return null;
  return el("ul", { class: "warnings" }, a.warnings.map(w => el("li", {}, el("strong", { text: w.code }), el("span", { text: w.message }), w.place && el("code", { text: w.place }))));
}

function links(a) {
  const all = [...a.pictures, ...a.denoised, ...files(a.views?.exr)];
  const link = path => el("li", {}, el("a", { href: address(path), target: "_blank", rel: "noopener", text: path.slice(path.lastIndexOf("/") + 1) }));
  if (!all.length) return null;
  return all.length > 4 ? el("details", {}, el("summary", { text: plural(all.length, "file") }), el("ul", { class: "files" }, all.map(link))) : el("ul", { class: "files" }, all.map(link));
}

/** Every figure of an asset. */
function figures(a) {
  const [camera, bounce, shadow] = a.rays ?? [];
  return el("div", { class: "figures" },
    el("p", { class: `verdict ${a.status}` }, mark(a.status), el("span", {}, el("b", { text: a.status }), " ", STATUS_TEXT[a.status] ?? "")),
    a.error && el("p", { class: "message" }, a.error[0] && el("strong", { text: a.error[0] }), a.error[1]),
    section("Warnings", warnings(a)),
    data.against !== null && section(`Against ${data.against}`, compared(a)),
    a.views && section("Accuracy", accuracy(a, 0)),
    section("Time", times(a)),
    section("Scene", list(
      row("Triangles", a.scene && whole.format(a.scene[0]), a.scene && a.scene[1] > 1 && `in ${plural(a.scene[1], "instance")}`),
      row("Light", a.light, a.scene?.[2] && plural(a.scene[2], "emitter")),
      row("Effects", a.effects.length ? a.effects.map(e => el("span", { class: "chip", text: e })) : null),
      row("Rays", a.rays && short(camera + bounce + shadow), a.rays && `${short(camera)} camera, ${short(bounce)} bounce, ${short(shadow)} shadow`),
      row("Not finite", a.nonfinite ? plural(a.nonfinite, "sample") : null, "dropped"),
      row("Peak memory", a.peak && bytes(a.peak)),
    )),
    section("Files", links(a), list(row("Seed", String(a.seed ?? 0)), row("Content", a.content && el("code", { text: a.content })))),
  );
}

/** Fills the dialog with an asset. */
function fill(a) {
  current = a;
  const place = state.shown.indexOf(a);
  const go = step => state.shown[place + step];
  const button = (label, sign, target) => el("button", { type: "button", class: "icon", "aria-label": label, title: label, disabled: !target, text: sign, onclick: () => open(target) });
  const close = el("button", { type: "button", class: "icon", "aria-label": "Close", title: "Close", text: "✕", onclick: () => dialog.close() });
  dialog.replaceChildren(
    el("header", {}, el("div", {}, el("h2", { id: "details-name", tabindex: -1, autofocus: true }, el("bdi", { text: a.name })), a.folder && el("p", {}, el("bdi", { text: a.folder.slice(0, -1) }))),
      el("nav", { "aria-label": "Assets" }, place >= 0 && el("span", { text: `${whole.format(place + 1)} of ${whole.format(state.shown.length)}` }),
        button("Previous asset", "←", place > 0 && go(-1)), button("Next asset", "→", place >= 0 && go(1)), close)),
    el("div", { class: "body" }, pictures(a), figures(a)));
}

/** Opens an asset; the address says which, so that it can be linked to and Back closes it. */
function open(a) {
  const hash = choice();
  hash.set("asset", a.input);
  if (dialog.open) history.replaceState(null, "", `#${hash}`);
  else history.pushState(null, "", `#${hash}`);
  show(a);
}

function show(a) {
  fill(a);
  if (!dialog.open) dialog.showModal();
}

dialog.addEventListener("close", () => {
  // It comes late: the next asset may have been opened since.
  if (dialog.open) return;
  const place = state.shown.indexOf(current);
  current = null;
  dialog.replaceChildren();
  const hash = choice().toString();
  history.replaceState(null, "", hash ? `#${hash}` : location.pathname + location.search);
  if (place >= 0) focus(place);
});
// A click beside the panel closes it.
dialog.addEventListener("click", event => event.target === dialog && dialog.close());
dialog.addEventListener("keydown", event => {
  if (event.target.matches("input, select") || event.altKey || event.ctrlKey || event.metaKey) return;
  const step = { ArrowLeft: -1, ArrowRight: 1 }[event.key];
  const target = step && state.shown[state.shown.indexOf(current) + step];
  if (!target) return;
  event.preventDefault();
  open(target);
  find("details-name").focus();
});
