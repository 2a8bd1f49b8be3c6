// Follows a run as it happens: the page asks for the document again whenever the trace has grown.

let isFollowed = true; // whether the newest call is chosen
let isWanted = false; // a newer document
let isFetching = false;

function post(command) {
  if (page.waits_for) fetch(command, { method: "POST" }).catch(() => {});
}

function tool(name, title, pressed) {
  const button = element("button", { title }, name);
  button.addEventListener("click", pressed);
  return button;
}

const STEPS = [
  tool("step", "To the next decision (s)", () => post("step")),
  tool("over", "Over the call (o)", () => post("over")),
  tool("continue", "To the next breakpoint (c)", () => post("go")),
];
const follow = tool("follow", "Choose the newest call (f)", () => setFollowed(!isFollowed));
const waiting = element("span", { id: "waiting", role: "status" });
document.querySelector("header").append(element("div", { class: "tools", id: "live" }, follow, ...STEPS, waiting));
Object.assign(KEYS, { s: () => post("step"), o: () => post("over"), c: () => post("go"), f: () => setFollowed(!isFollowed) });

function setFollowed(value) {
  isFollowed = value;
  follow.setAttribute("aria-pressed", value);
  if (value && page.rows.length) reveal(page.rows.length - 1);
}

// One fetch at a time, so that an older document never comes after a newer one.
async function refresh() {
  isWanted = true;
  if (isFetching) return;
  isFetching = true;
  try {
    while (isWanted) {
      isWanted = false;
      await fetchOnce();
    }
  } finally {
    isFetching = false;
  }
}

async function fetchOnce() {
  const answer = await fetch("document");
  if (!answer.ok) return;
  Object.assign(page, await answer.json());
  waiting.textContent = !page.goes_on ? "the run is over" : page.waits_for ? `waits before: ${page.waits_for}` : "running";
  for (const button of STEPS) button.hidden = !page.waits_for;
  drawWhole();
  if (!page.rows.length) return;
  updateVisible();
  if (isFollowed) reveal(page.rows.length - 1);
  else notify("row");
}

document.addEventListener("keydown", (event) => {
  if (isFollowed && /^(Arrow|Page|Home|End|n$|p$|\/$)/.test(event.key)) setFollowed(false);
});
byId("tree").addEventListener("click", () => setFollowed(false));
setFollowed(true);
const stream = new EventSource("events");
stream.addEventListener("message", refresh);
stream.addEventListener("error", () => {
  stream.close();
  if (page.goes_on) waiting.textContent = "the connection to the run is lost";
});
for (const [key, meaning] of [["s o c", "step, over, continue"], ["f", "follow the newest call"]]) {
  document.querySelector("#keys dl").append(element("dt", {}, key), element("dd", {}, meaning));
}
