"use strict";
// The tree: rows of equal height; only visible rows are in the document.

const ROW = 22;  // height [pixels], as in the style sheet
const FOLDED_ABOVE = 40;  // number of nodes above which sub-trees without running or failed nodes are folded
const PAST = 60;  // simulated time for which past states are kept [s]
const SIGNS = { IDLE: "·", RUNNING: "▶", SUCCESS: "✓", FAILURE: "✗", SKIPPED: "-" };
const IDLE = ["IDLE", "", null, null];

function makeTree(element, page) {
  const cell = (name) => Object.assign(document.createElement("span"), { className: name });
  const div = (name) => Object.assign(document.createElement("div"), { className: name });
  const node = div("treebox"), tools = div("treetools"), problems = div("error"), rows = div("rows"), space = div("");
  const search = Object.assign(document.createElement("input"), { type: "search", placeholder: "Search (/)", ariaLabel: "Search" });
  const follow = Object.assign(document.createElement("input"), { type: "checkbox", checked: page.saved("follow") ?? true });
  const followLabel = document.createElement("label");
  followLabel.append(follow, " Follow");
  followLabel.title = "Unfold running and failed nodes, and scroll to them";
  const whole = Object.assign(document.createElement("button"), { textContent: "⬑ Whole tree", hidden: true });
  tools.append(whole, search, followLabel);
  rows.tabIndex = 0;
  rows.setAttribute("role", "tree");
  rows.setAttribute("aria-label", "Tree");
  rows.append(space);
  node.append(tools, problems, rows);

  let nodes = new Map(), children = new Map(), depths = new Map(), source = null;
  let alone = 0;  // the sub-tree shown alone
  let shown = [], pool = [], running = 0;
  const folds = page.saved("folds") ?? {};
  let past = [], base = {};  // changes of the last minute, and the states before

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
    past = []; base = {};
  }

  // States

  function note(kind, name, values) {
    if (name != "states") return;
    const now = page.now();
    past.push([now, kind, values]);
    while (past.length && past[0][0] < now - PAST) base = applied(base, past.shift());
  }

  const applied = (states, [, kind, values]) => kind == "set" ? { ...values } : Object.assign(states, values);

  function states() {
    const time = page.shown();
    if (time === null) return element.props.states;
    let found = { ...base };
    for (const one of past) {
      if (one[0] > time) break;
      found = applied(found, one);
    }
    return found;
  }

  function state(uid) { return states()[uid] ?? IDLE; }

  // Rows

  function ancestors(uids) {
    const found = new Set();
    for (let uid of uids) while (uid && !found.has(uid) && nodes.has(uid)) { found.add(uid); uid = nodes.get(uid).parent; }
    return found;
  }

  function isOpen(uid, now, active) {
    const chosen = folds[nodes.get(uid).path];
    if (chosen !== undefined) return chosen;
    if (uid == alone || nodes.size <= FOLDED_ABOVE) return true;
    return follow.checked && active.has(uid) && now[uid]?.[0] != "SUCCESS";
  }

  function visible(now) {
    const wanted = search.value.trim().toLowerCase();
    const of = (status) => Object.keys(now).filter((uid) => now[uid][0] == status).map(Number);
    const active = ancestors([...of("RUNNING"), ...of("FAILURE")]);
    let matching = null;
    if (wanted) {
      const hits = source.filter((one) => `${one.name} ${one.registration}`.toLowerCase().includes(wanted));
      matching = ancestors(hits.map((one) => one.uid));
    }
    const found = [], stack = alone ? [alone] : [...(children.get(0) ?? [])].reverse();
    while (stack.length) {
      const uid = stack.pop();
      if (matching && !matching.has(uid)) continue;
      const open = !isParent(uid) ? null : matching !== null || isOpen(uid, now, active);
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
    const p = element.props, now = states();
    problems.textContent = p.problems.length ? `The edited file has errors, the tree goes on as it was:\n${p.problems.join("\n")}` : "";
    problems.hidden = !p.problems.length;
    whole.hidden = !alone;
    shown = visible(now);
    space.style.height = `${shown.length * ROW}px`;
    const leaves = Object.keys(now).map(Number).filter((uid) => now[uid][0] == "RUNNING" && !isParent(uid) && nodes.has(uid));
    const latest = leaves.sort((a, b) => now[b][2] - now[a][2])[0] ?? 0;
    if (latest && latest != running && follow.checked) reveal(latest);
    running = latest;
    drawRows(now);
  }

  function drawRows(now) {
    const first = Math.max(0, Math.floor(rows.scrollTop / ROW) - 2);
    const count = Math.min(shown.length - first, Math.ceil(rows.clientHeight / ROW) + 4);
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
    const line = div("line"), parts = {};
    for (const name of ["margin", "fold", "sign", "name", "kind", "message", "took"]) line.append(parts[name] = cell(name));
    line.setAttribute("role", "treeitem");
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
    set("top", i, () => { one.line.style.top = `${i * ROW}px`; });
    set("class", `line ${status}${uid == page.selected ? " chosen" : ""}${red.has(uid) ? " red" : ""}`, (v) => { one.line.className = v; });
    set("depth", depths.get(uid) - base, (v) => { one.parts.fold.style.marginLeft = `${12 * v}px`; });
    set("margin", broken.has(item.path), (v) => {
      one.parts.margin.textContent = v ? "●" : "";
      one.parts.margin.className = v ? "margin set" : "margin";
    });
    set("fold", open === null ? "" : open ? "▾" : "▸", (v) => { one.parts.fold.textContent = v; });
    set("sign", SIGNS[status] ?? "?", (v) => { one.parts.sign.textContent = v; one.parts.sign.title = status; });
    set("name", item.name, (v) => { one.parts.name.textContent = v; });
    set("kind", item.registration == item.name ? "" : item.registration, (v) => { one.parts.kind.textContent = v; });
    set("message", message, (v) => { one.parts.message.textContent = one.parts.message.title = v; });
    set("took", took >= 0.005 ? `${took.toFixed(2)} s` : "", (v) => { one.parts.took.textContent = v; });
    if (open !== null) one.line.setAttribute("aria-expanded", open);
    one.line.setAttribute("aria-selected", uid == page.selected);
  }

  function reveal(uid) {
    const i = shown.findIndex(([one]) => one == uid);
    if (i < 0) return;
    const top = i * ROW;
    if (top < rows.scrollTop) rows.scrollTop = Math.max(0, top - 2 * ROW);
    else if (top + ROW > rows.scrollTop + rows.clientHeight) rows.scrollTop = top - rows.clientHeight + 3 * ROW;
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
  rows.addEventListener("keydown", (event) => {
    const at = shown.findIndex(([uid]) => uid == page.selected), uid = page.selected;
    const go = (i) => { const to = shown[Math.min(Math.max(i, 0), shown.length - 1)]; if (to) { page.select(to[0]); reveal(to[0]); } };
    const parent = () => { if (nodes.has(uid)) go(shown.findIndex(([one]) => one == nodes.get(uid).parent)); };
    const keys = {
      ArrowDown: () => go(at + 1), ArrowUp: () => go(at - 1), Home: () => go(0), End: () => go(shown.length - 1),
      PageDown: () => go(at + 10), PageUp: () => go(at - 10),
      ArrowRight: () => { if (shown[at]?.[1] === false) fold(uid, true); else if (shown[at]?.[1]) go(at + 1); },
      ArrowLeft: () => { if (shown[at]?.[1]) fold(uid, false); else parent(); },
      Enter: () => fold(uid), b: () => { if (nodes.has(uid)) breakpoint(uid); },
      Escape: () => { alone = 0; search.value = ""; draw(); }, "/": () => search.focus(),
    };
    if (!keys[event.key] || event.ctrlKey || event.metaKey || event.altKey) return;
    event.preventDefault();
    keys[event.key]();
  });
  search.addEventListener("keydown", (event) => {
    if (event.key == "Escape") search.value = "";
    if (event.key == "Escape" || event.key == "Enter") { draw(); rows.focus(); }
  });
  search.oninput = draw;
  follow.onchange = () => { page.save("follow", follow.checked); running = 0; draw(); };
  rows.addEventListener("scroll", () => drawRows(states()));
  new ResizeObserver(() => drawRows(states())).observe(rows);

  return { node, draw, note, state, find: (uid) => nodes.get(uid), follows: [] };
}
