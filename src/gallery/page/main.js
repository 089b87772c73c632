// The page begins.

const THEMES = [["auto", "◐", "Colours: as the system"], ["light", "☀", "Colours: light"], ["dark", "☾", "Colours: dark"]];
let theme = THEMES.findIndex(([id]) => id === memory.get("theme"));

function paint(index) {
  theme = (index + THEMES.length) % THEMES.length;
  const [id, sign, title] = THEMES[theme];
  document.documentElement.dataset.theme = id;
  Object.assign(find("theme"), { textContent: sign, title });
  find("theme").setAttribute("aria-label", title);
}
paint(Math.max(0, theme));
find("theme").addEventListener("click", () => { paint(theme + 1); memory.set("theme", THEMES[theme][0]); });

find("title").textContent = data.title;
const here = assets.filter(a => a.status !== "gone");
const sum = (of) => here.reduce((total, a) => total + of(a), 0);
const frames = sum(a => a.count || (a.views ? 1 : 0));
const triangles = sum(a => a.scene?.[0] ?? 0);
find("facts").textContent = [
  plural(here.length, "asset"),
  frames !== here.length && plural(frames, "picture"),
  triangles > 0 && `${short(triangles)} triangles`,
  `${seconds(sum(a => a.cpu[5]))} of CPU time`,
  data.against !== null && `compared with ${data.against}`,
  `Kiln ${data.kiln}`,
].filter(Boolean).join(" · ");

for (const status of present) {
  const part = el("span", { class: status });
  part.style.flexGrow = assets.filter(a => a.status === status).length;
  find("share").append(part);
}
if (data.unreadable) {
  const lines = plural(data.unreadable, "line");
  find("notice").textContent = `${lines} of the manifest cannot be read: the batch was ended while writing. What it says of the other assets is whole.`;
  find("notice").hidden = false;
}

/** Takes everything from the address. */
function follow() {
  const hash = new URLSearchParams(location.hash.slice(1));
  choose(hash);
  search.value = state.query;
  const wanted = byInput.get(hash.get("asset"));
  update({ keepPlace: Boolean(wanted) });
  if (wanted) show(wanted);
  else if (dialog.open) dialog.close();
}
addEventListener("popstate", follow);
follow();
document.documentElement.dataset.ready = "yes";
