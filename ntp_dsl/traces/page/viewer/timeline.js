// The demonstration over time: its calls, and the scopes of the chosen call and its callers.

const NESTED = 3; // scopes that are shown below each other

function percent(frame) {
  return `${(100 * frame) / Math.max(1, page.demonstration.frames)}%`;
}

function bar(scope, label, className) {
  const box = element("span", { class: className, title: `${label} frames ${scope[0]} – ${scope[1]}` }, label);
  box.style.left = percent(scope[0]);
  box.style.width = percent(Math.max(scope[1] - scope[0], 0.5));
  return box;
}

function track(title, className, bars, tall) {
  return [element("span", { class: className }, title), element("div", { class: tall ? "track tall" : "track" }, ...bars)];
}

function drawTimeline() {
  const demonstration = page.demonstration;
  const parts = [];
  demonstration.said.forEach((text, number) => {
    parts.push(element("span", { class: "dim" }, number ? "" : "said"), element("q", {}, text));
  });
  if (demonstration.calls.length) parts.push(...track("demonstrated", "dim", demonstration.calls.map(([name, scope]) => bar(scope, name, ""))));
  if (demonstration.closed.length) parts.push(...track("hand closed", "dim", demonstration.closed.map((scope) => bar(scope, "", "closed"))));
  const shown = demonstration.said.length ? [] : SIDES; // what was said has no frames
  for (const side of shown) parts.push(...track(`scopes ${letter(side)}`, `side-${side}`, scopes(side), true));
  byId("timeline").replaceChildren(...parts);
  drawCursor();
}

// Marks the shown frame of the demonstration on each track.
function drawCursor() {
  for (const box of document.querySelectorAll("#timeline .track")) {
    const cursor = box.querySelector(".cursor") || box.appendChild(element("i", { class: "cursor" }));
    cursor.style.left = percent(chosen.shown);
  }
}

// Returns the scopes of the chosen call and its nearest callers.
function scopes(side) {
  const bars = [];
  for (let number = chosen.row; number >= 0 && bars.length < NESTED; number = page.rows[number].parent) {
    const callData = call(page.rows[number], side);
    if (callData && callData.scope) bars.unshift(bar(callData.scope, callText(callData), `scope side-${side}`));
  }
  bars.forEach((box, level) => {
    box.style.top = `${level * 1.1}rem`;
  });
  return bars;
}
