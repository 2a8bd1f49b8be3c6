// The chosen call of each trace: its outcome and the alternatives of its decision. A trace without such a call
// shows what it did instead: another call, or the return of its caller.

function drawDetail() {
  const row = page.rows[chosen.row];
  const divergences = page.divergences.filter((each) => each.row === chosen.row);
  const cards = SIDES.map((side) => card(side, call(row, side) || call(divergences[0] || {}, side)));
  byId("detail").replaceChildren(...divergences.map(divergenceNote), element("div", { class: "cards" }, ...cards));
}

function divergenceNote(divergence) {
  const confidence = divergence.margin === null ? "" : ` margin ${divergence.margin.toFixed(2)}, the right choice ${
    divergence.rank === null ? "is not among the alternatives" : `has rank ${divergence.rank}`
  }.`;
  const distance = divergence.state_distance === null ? "" : ` The states differ by ${(1000 * divergence.state_distance).toFixed(1)} mm.`;
  return element(
    "div",
    { class: "divergence", role: "note" },
    element("strong", { class: "bad" }, `≠ ${divergence.kind}`),
    `${divergence.attributed_to ? ` attributed to: ${divergence.attributed_to}.` : ""}${confidence}${distance} `,
    element("span", {}, `A ${divergence.did_a}; B ${divergence.did_b}. `),
    element("code", {}, divergence.source + (divergence.statement ? `: ${divergence.statement}` : "")),
  );
}

function card(side, callData) {
  const title = element("h2", { class: `side-${side}` }, `${letter(side)} ${callData ? callText(callData) : "–"}`);
  if (!callData) return element("article", { class: "card" }, title, "no such call");
  const facts = {
    outcome: callData.outcome || "cut off",
    scope: callData.scope ? `frames ${callData.scope[0]} – ${callData.scope[1]}` : "none",
    probability: probability(callData.probability),
    time: timeText(callData.times),
    "attributed to": callData.attributed_to,
    disturbances: callData.disturbances.join(", "),
    evidence: callData.evidence,
    source: callData.source + (callData.statement ? `: ${callData.statement}` : ""),
    frames: `${callData.frame} – ${callData.end_frame ?? ""}`,
  };
  const list = element("dl", { class: "facts" });
  for (const [name, value] of Object.entries(facts)) {
    if (value) list.append(element("dt", {}, name), element("dd", {}, value));
  }
  return element("article", { class: "card" }, title, list, alternatives(callData, side));
}

function alternatives(callData, side) {
  const box = element("div", { class: `alternatives side-${side}` });
  for (const [title, ranking] of callData.alternatives) {
    box.append(element("h3", {}, title));
    for (const [name, value] of ranking) {
      const bar = element("span", { class: "bar", "aria-hidden": "true" }, element("i", {}));
      bar.firstChild.style.width = `${100 * Math.min(1, Math.max(0, value))}%`;
      box.append(element("div", { class: "choice" }, element("span", {}, name), bar, probability(value)));
    }
  }
  return box;
}
