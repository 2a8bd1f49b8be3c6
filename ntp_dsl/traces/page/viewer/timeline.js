// The demonstration from left to right: what it shows, and the scopes of the chosen call and its callers.

const NESTED = 3; // scopes, one in another

function share(frame) {
  return `${(100 * frame) / Math.max(1, page.demonstration.frames)}%`;
}

function bar(scope, label, className) {
  const made = element("span", { class: className, title: `${label} frames ${scope[0]} – ${scope[1]}` }, label);
  made.style.left = share(scope[0]);
  made.style.width = share(Math.max(scope[1] - scope[0], 0.5));
  return made;
}

function track(title, className, bars, tall) {
  return [element("span", { class: className }, title), element("div", { class: tall ? "track tall" : "track" }, ...bars)];
}

function drawTimeline() {
  const shown = page.demonstration;
  const parts = [];
  if (shown.calls.length) parts.push(...track("shown", "dim", shown.calls.map(([name, scope]) => bar(scope, name, ""))));
  if (shown.closed.length) parts.push(...track("hand closed", "dim", shown.closed.map((scope) => bar(scope, "", "closed"))));
  for (const side of SIDES) parts.push(...track(`scopes ${letter(side)}`, `side-${side}`, scopes(side), true));
  byId("timeline").replaceChildren(...parts);
}

// Of the chosen call and its nearest callers, one below the other.
function scopes(side) {
  const bars = [];
  for (let number = chosen.row; number >= 0 && bars.length < NESTED; number = page.rows[number].above) {
    const made = call(page.rows[number], side);
    if (made && made.scope) bars.unshift(bar(made.scope, words(made), `scope side-${side}`));
  }
  bars.forEach((each, level) => {
    each.style.top = `${level * 14}px`;
  });
  return bars;
}
