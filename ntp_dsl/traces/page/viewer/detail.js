// The chosen call of each trace: what came of it, and what else the decision might have been. Where one has no
// such call, what it did at that moment: another call, or the return of its caller.

function drawDetail() {
  const row = page.rows[chosen.row];
  const found = page.divergences.filter((each) => each.row === chosen.row);
  const cards = SIDES.map((side) => card(side, call(row, side) || call(found[0] || {}, side)));
  byId("detail").replaceChildren(...found.map(parting), element("div", { class: "cards" }, ...cards));
}

function parting(found) {
  const sure = found.margin === null ? "" : ` margin ${found.margin.toFixed(2)}, the right answer ${
    found.rank === null ? "is not among the likely ones" : `stood at ${found.rank}`
  }.`;
  const apart = found.apart === null ? "" : ` The states lie ${(1000 * found.apart).toFixed(1)} mm apart.`;
  return element(
    "div",
    { class: "parts", role: "note" },
    element("strong", { class: "bad" }, `≠ ${found.kind}`),
    `${found.attributed_to ? ` attributed to: ${found.attributed_to}.` : ""}${sure}${apart} `,
    element("span", {}, `A ${found.did_a}; B ${found.did_b}. `),
    element("code", {}, found.source + (found.statement ? `: ${found.statement}` : "")),
  );
}

function card(side, made) {
  const title = element("h2", { class: `side-${side}` }, `${letter(side)} ${made ? words(made) : "–"}`);
  if (!made) return element("article", { class: "card" }, title, "no such call");
  const facts = {
    outcome: made.outcome || "cut off",
    scope: made.scope ? `frames ${made.scope[0]} – ${made.scope[1]}` : "none",
    probability: probability(made.probability),
    time: spent(made.times),
    "attributed to": made.attributed_to,
    disturbed: made.disturbances.join(", "),
    evidence: made.evidence,
    source: made.source + (made.statement ? `: ${made.statement}` : ""),
    frames: `${made.frame} – ${made.end_frame ?? ""}`,
  };
  const list = element("dl", { class: "facts" });
  for (const [name, value] of Object.entries(facts)) {
    if (value) list.append(element("dt", {}, name), element("dd", {}, value));
  }
  return element("article", { class: "card" }, title, list, alternatives(made, side));
}

function alternatives(made, side) {
  const box = element("div", { class: `alternatives side-${side}` });
  for (const [title, ranking] of made.alternatives) {
    box.append(element("h3", {}, title));
    for (const [name, value] of ranking) {
      const bar = element("span", { class: "bar", "aria-hidden": "true" }, element("i", {}));
      bar.firstChild.style.width = `${100 * Math.min(1, Math.max(0, value))}%`;
      box.append(element("div", { class: "choice" }, element("span", {}, name), bar, probability(value)));
    }
  }
  return box;
}
