// The chosen call of each trace: what came of it, what its caller saw, and the alternatives of the decision. A trace
// without such a call shows what it did instead: another call, or the return of its caller.

const MOST_FACTS = 12; // that a decision shows at first
const STATUS_MARKS = { due: "▶", achieved: "✓", "passed over": "–", absent: "∅", "in vain": "↩" };

function drawDetail() {
  const divergences = page.divergences.filter((each) => each.row === chosen.row);
  const calls = chosenCalls();
  const cards = SIDES.map((side, place) => card(side, calls[place]));
  byId("detail").replaceChildren(...divergences.map(divergenceNote), element("div", { class: "cards" }, ...cards));
}

function divergenceNote(divergence) {
  const rank = divergence.rank === null ? "is not among the alternatives" : `has rank ${divergence.rank}`;
  const confidence = divergence.margin === null ? "" : ` B preferred it by ${percentage(divergence.margin)}; the right choice ${rank}.`;
  return element(
    "div",
    { class: "divergence", role: "note" },
    element("strong", { class: "bad" }, `≠ ${divergence.kind}`),
    divergence.attributed_to ? ` attributed to: ${divergence.attributed_to}. ` : " ",
    element("span", {}, `A ${divergence.did_a}; B ${divergence.did_b}. `),
    divergence.differences ? element("span", {}, `The states differ: ${divergence.differences}.`) : "",
    confidence,
    " ",
    element("code", {}, divergence.source + (divergence.statement ? `: ${divergence.statement}` : "")),
  );
}

function card(side, callData) {
  const title = element("h2", { class: `side-${side}` }, `${letter(side)} ${callData ? callText(callData) : "–"}`);
  if (!callData) return element("article", { class: "card" }, title, "no such call");
  const facts = {
    outcome: outcome(callData),
    "not achieved": callData.unmet.join(", "),
    "attributed to": callData.attributed_to,
    disturbances: callData.disturbances.join(", "),
    source: callData.source + (callData.statement ? `: ${callData.statement}` : ""),
    probability: percentage(callData.probability),
    reads: callData.scope ? `frames ${callData.scope[0]} – ${callData.scope[1]} of the demonstration` : "",
    frames: `${callData.frame} – ${callData.end_frame ?? ""}`,
    time: timeText(callData.times),
    measured: callData.evidence,
    changed: callData.became.join(", "),
  };
  const list = element("dl", { class: "facts" });
  for (const [name, value] of Object.entries(facts)) {
    if (value) list.append(element("dt", {}, name), element("dd", {}, value));
  }
  const parts = [...state(callData), decision("why it was called", callData.made, side)];
  if (callData.returned) parts.push(decision("why it returned", callData.returned, side));
  return element("article", { class: "card" }, title, list, ...parts);
}

// The facts of the state in which a call was made; nothing where a library has no state.
function state(callData) {
  const holds = callData.holds.map((each) => element("div", {}, page.texts[each]));
  return holds.length ? [element("details", {}, element("summary", {}, `state: ${holds.length} ${holds.length === 1 ? "fact" : "facts"}`), ...holds)] : [];
}

// What a decision rested on; an empty element where the trace says nothing.
function decision(title, made, side) {
  const box = element("section", {});
  const parts = [...made.notes.map((note) => element("p", {}, note)), ...statements(made), ...factTable(made), ...alternatives(made, side)];
  if (parts.length) box.append(element("h3", {}, title), ...parts);
  return box;
}

function statements(made) {
  return made.statements.map(([text, line, status, lacks]) => {
    const lacking = lacks.length && status === "due" ? ` lacks ${lacks.map((each) => page.texts[each]).join(", ")}` : "";
    return element(
      "div",
      { class: `statement ${status === "due" ? "due" : "dim"}`, title: status },
      element("span", { "aria-label": status }, STATUS_MARKS[status] || status),
      element("span", {}, `line ${line} ${page.texts[text]}`, element("span", { class: "dim" }, lacking)),
    );
  });
}

// Facts that were seen wrongly come first, then those that did not hold or were not sure; the rest is folded away.
function factTable(made) {
  const isWrong = ([, seen, truth]) => truth !== null && seen > 0.5 !== truth;
  const wrong = made.facts.filter(isWrong);
  const telling = made.facts.filter((fact) => !isWrong(fact) && fact[1] < SURE);
  const held = made.facts.filter((fact) => !isWrong(fact) && fact[1] >= SURE);
  const first = [...wrong, ...telling];
  const parts = first.length ? [facts(first.slice(0, MOST_FACTS), isWrong)] : [];
  parts.push(...folded("more", first.slice(MOST_FACTS), isWrong), ...folded("that held", held, isWrong));
  return parts;
}

function folded(title, rows, isWrong) {
  return rows.length ? [element("details", {}, element("summary", {}, `${rows.length} ${title}`), facts(rows, isWrong))] : [];
}

function facts(rows, isWrong) {
  const table = element("table", {}, element("tr", {}, ...["fact", "seen", "true"].map((name) => element("th", { scope: "col" }, name))));
  for (const fact of rows) {
    const [text, seen, truth] = fact;
    const truly = truth === null ? "" : truth ? "yes" : "no";
    const cells = [page.texts[text], percentage(seen), truly].map((each) => element("td", {}, each));
    table.append(element("tr", isWrong(fact) ? { class: "bad" } : {}, ...cells));
  }
  return table;
}

function alternatives(made, side) {
  const box = element("div", { class: `alternatives side-${side}` });
  for (const [title, ranking] of made.alternatives) {
    box.append(element("h4", {}, title));
    for (const [name, value] of ranking) {
      const bar = element("span", { class: "bar", "aria-hidden": "true" }, element("i", {}));
      bar.firstChild.style.width = `${100 * Math.min(1, Math.max(0, value))}%`;
      box.append(element("div", { class: "choice" }, element("span", {}, name), bar, percentage(value)));
    }
  }
  return made.alternatives.length ? [box] : [];
}
