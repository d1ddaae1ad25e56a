"use strict";
// The tree; only visible rows are in the document.

const ROW = 22;  // height of a line [pixels], as in the style sheet
const BELOW = 18;  // height that a message below its node adds [pixels], as in the style sheet
const LETTER = 6.5;  // mean width of a letter [pixels]
const LETTERS = 20;  // a message with less room than this goes below its node
const FOLDED_ABOVE = 40;  // number of nodes above which sub-trees without running or failed nodes are folded
const SIGNS = { IDLE: "·", RUNNING: "▶", SUCCESS: "✓", FAILURE: "✗", SKIPPED: "-" };
const ANSWERS = { SUCCESS: "yes", FAILURE: "no" };  // of conditions: a "no" is no failure of the task
const IDLE = ["IDLE", "", null, null];

const statusOf = (node, status) => (node.kind == "Condition" && ANSWERS[status]) || status.toLowerCase();

function makeTree(element, page) {
  const search = make("input", { type: "search", placeholder: "Search (/)", ariaLabel: "Search" });
  const follow = make("input", { type: "checkbox", checked: page.saved("follow") ?? true });
  const followLabel = make("label", { title: "Unfold running and failed nodes, and scroll to them" }, follow, " Follow");
  const whole = make("button", { textContent: "⬑ Whole tree", hidden: true });
  const edited = make("div", { className: "edited", textContent: "The file was edited: it is read when the run goes on.", hidden: true });
  const problems = make("div", { className: "error" }), space = make("div");
  const rows = make("div", { className: "rows", tabIndex: 0, role: "tree", ariaLabel: "Tree" }, space);
  const node = make("div", { className: "treebox" }, make("div", { className: "treetools" }, whole, search, followLabel), edited, problems, rows);

  let nodes = new Map(), children = new Map(), depths = new Map(), source = null;
  let alone = 0;  // the sub-tree shown alone
  let shown = [], tops = [0], pool = [], running = 0;  // top of each shown row, and of the one after [pixels]
  const widths = new Map(), ruler = document.createElement("canvas").getContext("2d");
  const folds = page.saved("folds") ?? {};

  const isParent = (uid) => children.has(uid);

  function read() {
    source = element.props.nodes;
    nodes = new Map(source.map((one) => [one.uid, one]));
    children = new Map(); depths = new Map();
    for (const one of source) {
      const parent = nodes.has(one.parent) ? one.parent : 0;
      if (!children.has(parent)) children.set(parent, []);
      children.get(parent).push(one.uid);
    }
    const stack = [...(children.get(0) ?? [])].reverse().map((uid) => [uid, 0]);
    while (stack.length) {
      const [uid, depth] = stack.pop();
      depths.set(uid, depth);
      for (const child of [...(children.get(uid) ?? [])].reverse()) stack.push([child, depth + 1]);
    }
    if (!nodes.has(alone)) alone = 0;
  }

  // Rows

  function ancestors(uids) {
    const found = new Set();
    for (let uid of uids) while (uid && !found.has(uid) && nodes.has(uid)) { found.add(uid); uid = nodes.get(uid).parent; }
    return found;
  }

  function levels(now) {
    // Number of levels of a large tree that are open where nothing runs: at least one, and as many as there is room for.
    if (Object.values(now).some(([status]) => status == "RUNNING")) return 0;
    const sizes = [];  // height by level [pixels]
    for (const [uid, depth] of depths) sizes[depth] = (sizes[depth] ?? 0) + height(uid, now);
    let open = 0, used = sizes[0];
    while (open < sizes.length - 1 && (used += sizes[open + 1]) <= rows.clientHeight) open++;
    return Math.max(open, 1);
  }

  function isOpen(uid, now, active, open) {
    const chosen = folds[nodes.get(uid).path];
    if (chosen !== undefined) return chosen;
    if (uid == alone || nodes.size <= FOLDED_ABOVE || depths.get(uid) < open) return true;
    return follow.checked && active.has(uid) && now[uid]?.[0] != "SUCCESS";
  }

  function visible(now) {
    const wanted = search.value.trim().toLowerCase();
    const of = (status) => Object.keys(now).filter((uid) => now[uid][0] == status).map(Number);
    const active = ancestors([...of("RUNNING"), ...of("FAILURE"), ...Object.keys(element.props.findings).map(Number)]);
    let matching = null;
    if (wanted) {
      const hits = source.filter((one) => `${one.name} ${one.registration}`.toLowerCase().includes(wanted));
      matching = ancestors(hits.map((one) => one.uid));
    }
    const deep = levels(now), found = [], stack = alone ? [alone] : [...(children.get(0) ?? [])].reverse();
    while (stack.length) {
      const uid = stack.pop();
      if (matching && !matching.has(uid)) continue;
      const open = !isParent(uid) ? null : matching !== null || isOpen(uid, now, active, deep);
      found.push([uid, open]);
      if (open) stack.push(...[...children.get(uid)].reverse());
    }
    return found;
  }

  function failedPath(now) {
    // The failed nodes from the root downwards.
    const red = new Set();
    const stack = [...(children.get(0) ?? [])];
    while (stack.length) {
      const uid = stack.pop();
      if (now[uid]?.[0] != "FAILURE") continue;
      red.add(uid);
      stack.push(...(children.get(uid) ?? []));
    }
    return red;
  }

  function draw() {
    if (source !== element.props.nodes) read();
    const p = element.props, now = p.states;
    edited.hidden = !p.edited;
    const heading = source.length ? "The edited file has errors, the tree goes on as it was:" : "The tree has errors:";
    problems.textContent = p.problems.length ? `${heading}\n${p.problems.join("\n")}` : "";
    problems.hidden = !p.problems.length;
    whole.hidden = !alone;
    shown = visible(now);
    tops = [0];
    for (const [uid] of shown) tops.push(tops.at(-1) + height(uid, now));
    space.style.height = `${tops.at(-1)}px`;
    const leaves = Object.keys(now).map(Number).filter((uid) => now[uid][0] == "RUNNING" && !isParent(uid) && nodes.has(uid));
    const latest = leaves.sort((a, b) => now[b][2] - now[a][2])[0] ?? 0;
    if (latest && latest != running && follow.checked) reveal(latest);
    running = latest;
    drawRows(now);
  }

  function width(text) {
    if (!widths.has(text)) { ruler.font = "bold 13px system-ui, sans-serif"; widths.set(text, ruler.measureText(text).width); }
    return widths.get(text);
  }

  const indent = (uid) => 52 + 12 * (depths.get(uid) - (alone ? depths.get(alone) : 0));  // of the name [pixels]
  const kindOf = (item) => item.registration == item.name ? "" : item.registration;

  function height(uid, now) {
    // The height of a row [pixels]: more where the message has no room beside the name.
    const [, message] = now[uid] ?? IDLE;
    if (!message) return ROW;
    const item = nodes.get(uid), kind = kindOf(item);
    const used = indent(uid) + Math.max(width(item.name), 48) + (kind ? width(kind) : 0) + (uid in element.props.findings ? 18 : 0) + 16 + 62;  // and the time
    return rows.clientWidth - used < LETTER * Math.min(LETTERS, message.length) ? ROW + BELOW : ROW;
  }

  function drawRows(now) {
    let first = 0, end = 0;
    while (first < shown.length && tops[first + 1] < rows.scrollTop - 2 * ROW) first++;
    for (end = first; end < shown.length && tops[end] < rows.scrollTop + rows.clientHeight + 2 * ROW;) end++;
    const count = end - first;
    while (pool.length < count) pool.push(newRow());
    const broken = new Set(element.props.breakpoints);
    const red = element.props.failed ? failedPath(now) : new Set();
    const base = alone ? depths.get(alone) : 0, time = page.time();
    const used = new Set();
    for (let i = first; i < first + count; i++) {
      const one = pool[i % pool.length];
      used.add(one);
      fill(one, i, now, broken, red, base, time);
    }
    for (const one of pool) one.line.hidden = !used.has(one);
  }

  function newRow() {
    const line = make("div", { className: "line", role: "treeitem" }), parts = {};
    for (const className of ["margin", "fold", "sign", "name", "found", "kind", "message", "took"]) line.append(parts[className] = make("span", { className }));
    parts.margin.title = "Breakpoint";
    rows.append(line);
    return { line, parts, set: {} };
  }

  function fill(one, i, now, broken, red, base, time) {
    const [uid, open] = shown[i], item = nodes.get(uid);
    const [status, message, start, end] = now[uid] ?? IDLE;
    const took = start === null ? NaN : (end ?? Math.max(time, start)) - start;
    const set = (key, value, how) => { if (one.set[key] !== value) { one.set[key] = value; how(value); } };
    set("uid", uid, () => { one.line.dataset.uid = uid; });
    set("top", tops[i], (v) => { one.line.style.top = `${v}px`; });
    const marks = { chosen: uid == page.selected, red: red.has(uid), answer: item.kind == "Condition", two: tops[i + 1] - tops[i] > ROW };
    set("class", ["line", status, ...Object.keys(marks).filter((mark) => marks[mark])].join(" "), (v) => { one.line.className = v; });
    set("indent", marks.two ? Math.min(indent(uid), rows.clientWidth - LETTER * LETTERS) : 0, (v) => { one.parts.message.style.paddingLeft = v ? `${v}px` : ""; });
    set("depth", depths.get(uid) - base, (v) => { one.parts.fold.style.marginLeft = `${12 * v}px`; });
    set("margin", broken.has(item.path), (v) => {
      one.parts.margin.textContent = v ? "●" : "";
      one.parts.margin.className = v ? "margin set" : "margin";
    });
    set("fold", open === null ? "" : open ? "▾" : "▸", (v) => { one.parts.fold.textContent = v; });
    set("sign", (marks.answer && ANSWERS[status]) || (SIGNS[status] ?? "?"), (v) => { one.parts.sign.textContent = v; one.parts.sign.title = statusOf(item, status); });
    set("name", item.name, (v) => { one.parts.name.textContent = v; });
    const found = element.props.findings[uid] ?? [];
    set("found", found.map(([, text]) => text).join("\n"), (v) => {
      one.parts.found.textContent = v ? "⚠" : "";
      one.parts.found.title = v;
      one.parts.found.className = `found ${found.some(([severity]) => severity == "error") ? "error" : ""}`;
    });
    set("kind", kindOf(item), (v) => { one.parts.kind.textContent = v; });
    set("message", message, (v) => { one.parts.message.textContent = one.parts.message.title = v; });
    set("took", took >= 0.005 ? `${took.toFixed(2)} s` : "", (v) => { one.parts.took.textContent = v; });
    if (open !== null) one.line.setAttribute("aria-expanded", open);
    one.line.setAttribute("aria-selected", uid == page.selected);
  }

  function reveal(uid) {
    const i = shown.findIndex(([one]) => one == uid);
    if (i < 0) return;
    const top = tops[i];
    if (top < rows.scrollTop) rows.scrollTop = Math.max(0, top - 2 * ROW);
    else if (tops[i + 1] > rows.scrollTop + rows.clientHeight) rows.scrollTop = top - rows.clientHeight + 3 * ROW;
  }

  // Input events

  function fold(uid, open) {
    if (!isParent(uid)) return;
    folds[nodes.get(uid).path] = open ?? !shown.find(([one]) => one == uid)?.[1];
    page.save("folds", folds);
    draw();
  }

  function breakpoint(uid) { element.send("breakpoint", nodes.get(uid).path); }

  const uidOf = (event) => Number(event.target.closest(".line")?.dataset.uid ?? 0);
  rows.addEventListener("click", (event) => {
    const uid = uidOf(event);
    if (!uid) return;
    if (event.target.classList.contains("margin")) breakpoint(uid);
    else if (event.target.classList.contains("fold")) fold(uid);
    else { page.select(uid); page.front(page.first("node")?.parent); }
  });
  rows.addEventListener("dblclick", (event) => {
    const uid = uidOf(event);
    if (uid && isParent(uid) && !event.target.matches(".margin, .fold")) { alone = uid; rows.scrollTop = 0; draw(); }
  });
  whole.onclick = () => { alone = 0; draw(); reveal(page.selected); };
  function key(event) {
    const at = shown.findIndex(([uid]) => uid == page.selected), uid = page.selected;
    const go = (i) => { const to = shown[Math.min(Math.max(i, 0), shown.length - 1)]; if (to) { page.select(to[0]); reveal(to[0]); } };
    const parent = () => { if (nodes.has(uid)) go(shown.findIndex(([one]) => one == nodes.get(uid).parent)); };
    const keys = {
      ArrowDown: () => go(at + 1), ArrowUp: () => go(at - 1), Home: () => go(0), End: () => go(shown.length - 1),
      PageDown: () => go(at + 10), PageUp: () => go(at - 10),
      ArrowRight: () => { if (shown[at]?.[1] === false) fold(uid, true); else if (shown[at]?.[1]) go(at + 1); },
      ArrowLeft: () => { if (shown[at]?.[1]) fold(uid, false); else parent(); },
      Enter: () => fold(uid), b: () => { if (nodes.has(uid)) breakpoint(uid); },
      Escape: () => { alone = 0; search.value = ""; draw(); },
    };
    if (!keys[event.key] || event.ctrlKey || event.metaKey || event.altKey) return;
    event.preventDefault();
    keys[event.key]();
  }
  search.addEventListener("keydown", (event) => {
    if (event.key == "Escape") search.value = "";
    if (event.key == "Escape" || event.key == "Enter") { draw(); rows.focus(); }
  });
  search.oninput = draw;
  follow.onchange = () => { page.save("follow", follow.checked); running = 0; draw(); };
  rows.addEventListener("scroll", () => drawRows(element.props.states));
  new ResizeObserver(() => { if (source) draw(); }).observe(rows);

  return { node, draw, key, find: (uid) => nodes.get(uid), follows: [] };
}
