// Keys, buttons, and the first drawing.

let searchStart = 0; // the chosen row when the search began: each keystroke searches from there

function search(again) {
  chosen.query = byId("search").value.trim().toLowerCase();
  const hits = [];
  if (chosen.query) {
    page.rows.forEach((row, number) => {
      if (SIDES.some((side) => call(row, side) && callText(call(row, side)).toLowerCase().includes(chosen.query))) hits.push(number);
    });
  }
  const ahead = hits.find((number) => (again ? number > chosen.row : number >= searchStart)) ?? hits[0];
  byId("found").textContent = chosen.query ? (hits.length ? `${hits.indexOf(ahead) + 1} of ${hits.length}` : "none") : "";
  if (ahead === undefined) drawTree();
  else reveal(ahead);
}

function toggleTheme() {
  const dark = getComputedStyle(document.documentElement).colorScheme === "dark" ||
    (!document.documentElement.dataset.theme && matchMedia("(prefers-color-scheme: dark)").matches);
  document.documentElement.dataset.theme = dark ? "light" : "dark";
}

const KEYS = {
  n: () => jump(1),
  p: () => jump(-1),
  t: toggleTheme,
  v: changeView,
  z: zoom,
  "/": () => byId("search").focus(),
  "?": () => byId("keys").showModal(),
  "[": () => scrub(chosen.frame - 1),
  "]": () => scrub(chosen.frame + 1),
  "{": () => scrub(chosen.frame - 10),
  "}": () => scrub(chosen.frame + 10),
  ",": () => scrubShown(chosen.shown - 1),
  ".": () => scrubShown(chosen.shown + 1),
  "<": () => scrubShown(chosen.shown - 10),
  ">": () => scrubShown(chosen.shown + 10),
  " ": play,
};

document.addEventListener("keydown", (event) => {
  if (event.target.id === "search") {
    if (event.key === "Enter") search(true);
    else if (event.key === "Escape") byId("tree").focus();
    return;
  }
  if (event.ctrlKey || event.metaKey || event.altKey || byId("keys").open) return;
  if (event.key === " " && ["BUTTON", "SUMMARY"].includes(event.target.tagName)) return; // which it presses
  if (Object.hasOwn(KEYS, event.key)) {
    KEYS[event.key]();
    event.preventDefault();
  }
});

byId("tree").addEventListener("keydown", treeKey);
byId("tree").addEventListener("scroll", drawTree);
byId("search").addEventListener("focus", () => {
  searchStart = chosen.row;
});
byId("search").addEventListener("input", () => search(false));
byId("next").addEventListener("click", () => jump(1));
byId("previous").addEventListener("click", () => jump(-1));
byId("theme").addEventListener("click", toggleTheme);
byId("help").addEventListener("click", KEYS["?"]);
byId("play").addEventListener("click", play);
byId("view").addEventListener("click", changeView);
byId("zoom").addEventListener("click", zoom);
byId("frame").addEventListener("input", (event) => scrub(Number(event.target.value)));
byId("shown").addEventListener("input", (event) => scrubShown(Number(event.target.value)));
byId("scenes").addEventListener("pointermove", drag);
window.addEventListener("resize", () => {
  measure();
  drawTree();
  drawScene();
});

chosen.watchers.push((change) => {
  if (change === "folding") return drawTree();
  if (change === "row") {
    drawDetail();
    drawTimeline(); // first, since its height determines how much of the tree is visible
    scrollToChosen();
  }
  byId("frame").value = chosen.frame;
  byId("shown").value = chosen.shown;
  byId("moment").textContent = `frame ${chosen.frame} of ${page.frames}, ${(chosen.frame / 10).toFixed(1)} s`;
  byId("shown-moment").textContent = `frame ${chosen.shown} of ${page.demonstration.frames}`;
  byId("play").textContent = playing.timer ? "stop" : "play";
  drawCursor();
  drawScene();
});

// Draws what is there from the beginning on.
function drawWhole() {
  document.body.classList.toggle("alone", SIDES.length === 1);
  byId("summary").textContent = page.summary;
  byId("overview").textContent = page.overview;
  byId("frame").max = Math.max(0, page.frames - 1);
  for (const each of document.querySelectorAll(".scrubber .of-demonstration")) each.hidden = page.demonstration.said.length > 0;
  byId("shown").max = Math.max(0, page.demonstration.frames - 1);
  for (const id of ["next", "previous"]) byId(id).hidden = !page.divergences.length;
  byId("heads").replaceChildren(...SIDES.flatMap((side, place) => [
    ...(place ? [element("span", {})] : []),
    element("div", { class: `side-${side}`, title: trace(side).origin }, `${letter(side)} ${trace(side).ending}`, element("small", { class: "dim" }, trace(side).origin)),
  ]));
  prepare();
  measure();
}

drawWhole();
foldUnchanged();
if (page.rows.length) {
  updateVisible();
  const first = page.divergences.find((each) => each.row >= 0);
  reveal(first ? first.row : page.begins_at);
}
byId("tree").focus();
document.body.dataset.ready = "yes";
