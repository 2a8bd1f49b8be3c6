// Both trees, row by row; only visible rows are in the document.

let height = 22; // [px] of a row

function measure() {
  height = Math.round(1.7 * parseFloat(getComputedStyle(document.documentElement).fontSize));
  document.documentElement.style.setProperty("--row", `${height}px`);
}

const MANY = 400; // rows, beyond which unchanged ones are folded at first

function cell(row, side, number) {
  const callData = call(row, side);
  const box = element("div", { role: "gridcell", class: "cell" });
  box.style.paddingLeft = `${Math.min(row.depth, 30) * 14}px`;
  if (!callData) return box;
  const folds = row.end > number + 1 && (side === "a" || row.a === null);
  const toggle = folds ? (chosen.folded.has(number) ? "▸" : "▾") : "";
  const name = element("span", { class: callData.program ? "program" : "side-" + side });
  highlight(name, callData.name);
  const args = element("span", {});
  highlight(args, `(${callData.arguments})`);
  const succeeded = callData.outcome === "done" || callData.outcome === "achieved";
  const runs = !callData.outcome && page.goes_on;
  const triangle = element("span", { class: "toggle", "aria-hidden": "true" }, toggle);
  const mark = succeeded ? "✓" : `${runs ? "…" : "✗"} ${outcome(callData)}`;
  const colour = succeeded ? "good" : runs ? "dim" : "bad";
  box.append(element("span", { class: "shrinks" }, triangle, name, args), element("span", { class: `outcome ${colour}` }, mark));
  if (callData.unmet.length) box.append(element("span", { class: "bad shrinks" }, `but not ${callData.unmet.join(", ")}`));
  const unsure = callData.probability !== null && callData.probability < SURE;
  const notes = [unsure ? percentage(callData.probability) : "", ...callData.disturbances];
  box.append(element("span", { class: "dim" }, notes.filter(Boolean).join(" ")));
  box.title = callText(callData);
  return box;
}

function highlight(box, text) {
  const at = chosen.query ? text.toLowerCase().indexOf(chosen.query) : -1;
  if (at < 0) return box.append(text);
  const end = at + chosen.query.length;
  box.append(text.slice(0, at), element("mark", {}, text.slice(at, end)), text.slice(end));
}

function rowElement(number, place) {
  const row = page.rows[number];
  const kind = row.mark === "same" ? "" : row.mark === "changed" ? " changed" : " only";
  const attributes = {
    role: "row",
    id: `row-${number}`,
    class: `row${kind}${number === chosen.row ? " chosen" : ""}`,
    "aria-level": row.depth + 1,
    "aria-rowindex": place + 1,
    "aria-selected": number === chosen.row,
  };
  if (row.end > number + 1) attributes["aria-expanded"] = !chosen.folded.has(number);
  const box = element("div", attributes, cell(row, "a", number));
  if (SIDES.length === 2) {
    const mark = element("div", { role: "gridcell", class: "mark", "aria-label": row.mark }, MARKS[row.mark]);
    box.append(mark, cell(row, "b", number));
  }
  box.style.top = `${place * height}px`;
  box.addEventListener("click", (event) => {
    if (event.target.classList.contains("toggle")) fold(number, !chosen.folded.has(number));
    choose(number);
  });
  return box;
}

function drawTree() {
  const tree = byId("tree");
  const rows = byId("rows");
  rows.style.height = `${chosen.visible.length * height}px`;
  const begin = Math.max(0, Math.floor(tree.scrollTop / height) - 10);
  const end = Math.min(chosen.visible.length, begin + Math.ceil(tree.clientHeight / height) + 20);
  const present = [];
  for (let place = begin; place < end; place += 1) present.push(rowElement(chosen.visible[place], place));
  rows.replaceChildren(...present);
  tree.setAttribute("aria-rowcount", chosen.visible.length);
  tree.setAttribute("aria-activedescendant", `row-${chosen.row}`);
}

function fold(number, folded) {
  if (page.rows[number].end <= number + 1) return;
  if (folded) chosen.folded.add(number);
  else chosen.folded.delete(number);
  updateVisible();
}

function scrollToChosen() {
  const tree = byId("tree");
  const top = visibleIndex(chosen.row) * height;
  if (top < tree.scrollTop) tree.scrollTop = top - 3 * height;
  else if (top + height > tree.scrollTop + tree.clientHeight) tree.scrollTop = top - tree.clientHeight + 4 * height;
  drawTree();
}

// Returns the index of a row among the visible ones, by bisection.
function visibleIndex(number) {
  let low = 0;
  for (let high = chosen.visible.length; low < high; ) {
    const middle = (low + high) >> 1;
    if (chosen.visible[middle] < number) low = middle + 1;
    else high = middle;
  }
  return low;
}

function step(by) {
  const place = Math.max(0, Math.min(chosen.visible.length - 1, visibleIndex(chosen.row) + by));
  choose(chosen.visible[place]);
}

function treeKey(event) {
  const leap = Math.max(1, Math.floor(byId("tree").clientHeight / height) - 1);
  const steps = { ArrowDown: 1, ArrowUp: -1, PageDown: leap, PageUp: -leap, Home: -Infinity, End: Infinity };
  const row = page.rows[chosen.row];
  if (!row) return;
  if (event.key in steps) step(steps[event.key]);
  else if (event.key === "ArrowRight" || event.key === "Enter") fold(chosen.row, false);
  else if (event.key === "ArrowLeft" && row.end > chosen.row + 1 && !chosen.folded.has(chosen.row)) fold(chosen.row, true);
  else if (event.key === "ArrowLeft" && row.parent >= 0) choose(row.parent);
  else return;
  event.preventDefault();
}

function foldUnchanged() {
  if (page.rows.length <= MANY) return;
  page.rows.forEach((row, number) => {
    if (row.depth >= 1 && row.unchanged && row.end > number + 1) chosen.folded.add(number);
  });
}
