"use strict";
// The connection to the server, and the layout. `page` has the state of this browser alone.

const NARROW = 900;  // width below which the tree is a tab [pixels]

const page = {
  elements: new Map(),  // by uid: uid, parent, kind, props, made, send
  selected: 0,  // uid of the selected node
  saved(name) { try { return JSON.parse(localStorage.getItem(`bt-manip ${name}`)) ?? undefined; } catch { return undefined; } },
  save(name, value) { try { localStorage.setItem(`bt-manip ${name}`, JSON.stringify(value)); } catch { /* private window */ } },
  first(kind) { for (const one of this.elements.values()) if (one.kind == kind) return one; },
  now() { return this.first("timeline")?.props.time ?? 0; },
  shown() { return this.first("timeline")?.props.shown ?? null; },
  time() { return this.shown() ?? this.now(); },
  select(uid) { this.selected = uid; for (const one of this.elements.values()) if (one.kind == "tree" || one.kind == "node") dirty.add(one); redraw(); },
  seek(time) { this.first("timeline")?.made.seek(time); },
  front(uid) { if (this.elements.get(uid)?.kind == "tab") showTab(uid); },
};

const dirty = new Set();
const byId = (id) => document.getElementById(id);
const places = { bar: byId("bar"), left: make("div", { className: "inleft" }), below: byId("below"), over: byId("over"), tabs: byId("tabs") };
const [list, left] = [byId("tabs").querySelector("nav"), byId("left")];
left.append(places.left);

// Changes from the server

function apply(changes) {
  for (const [what, uid, ...rest] of changes) {
    if (what == "reset") { for (const one of [...page.elements.values()]) remove(one.uid); continue; }
    if (what == "add") { add(uid, ...rest); continue; }
    const element = page.elements.get(uid);
    if (!element) continue;
    if (what == "remove") { remove(uid); continue; }
    if (what == "set") {
      Object.assign(element.props, rest[0]);
    } else if (what == "merge") {
      Object.assign(element.props[rest[0]], rest[1]);
    } else if (what == "append") {
      const [name, values, keep] = rest;
      element.props[name] = [...element.props[name], ...values].slice(-keep);
    }
    touch(element);
  }
  redraw();
}

function touch(element) {
  dirty.add(element);
  for (const one of page.elements.values()) if (one.made.follows?.includes(element.kind)) dirty.add(one);
}

function redraw() {
  for (const { made, props } of dirty) if (made.node) made.node.hidden = !props.visible;
  const tabs = [...dirty].filter((one) => one.kind == "tab");
  for (const one of tabs) {
    dirty.delete(one);
    if (one.props.front > one.made.front) front = one.props.label;
    one.made.front = one.props.front ?? 0;
  }
  if (tabs.length) drawTabs();
  for (const element of [...dirty]) {
    const { node, draw } = element.made;
    // Hidden elements are drawn when their tab is shown.
    if (draw && node.isConnected && node.offsetParent === null && element.props.visible && element.kind != "status") continue;
    dirty.delete(element);
    draw?.();
  }
}

function add(uid, parent, kind, props) {
  const element = { uid, parent, kind, props, made: {} };
  element.send = (event, value) => {
    if (socket.readyState == WebSocket.OPEN) socket.send(JSON.stringify({ id: uid, event, value }));
  };
  page.elements.set(uid, element);
  if (kind in places) element.made = { inner: places[kind] };
  else if (kind == "tab") element.made = addTab(element);
  else {
    element.made = (WIDGETS[kind] ?? (() => ({ node: make("div") })))(element, page);
    (page.elements.get(parent)?.made.inner ?? places.tabs).append(element.made.node);
  }
  dirty.add(element);
}

function remove(uid) {
  for (const one of [...page.elements.values()]) if (one.parent == uid) remove(one.uid);
  const element = page.elements.get(uid);
  if (!element) return;
  element.made.node?.remove();
  if (element.kind == "tab") { element.made.inner.remove(); element.made.button.remove(); }
  page.elements.delete(uid);
  dirty.delete(element);
}

// Tabs

let front = page.saved("tab") ?? "Log";  // name of the tab at the front

function addTab(element) {
  const inner = make("div", { className: "tab", role: "tabpanel", hidden: true });
  const button = make("button", { role: "tab", textContent: element.props.label, onclick: () => showTab(element.uid) });
  list.append(button);
  places.tabs.append(inner);
  return { inner, button, front: element.props.front ?? 0 };
}

function showTab(uid) {
  front = uid === "tree" ? "Tree" : page.elements.get(uid).props.label;
  page.save("tab", front);
  if (sizes.tabs < 40) setSize("tabs", 340);
  drawTabs();
  redraw();
}

function drawTabs() {
  const tabs = [...page.elements.values()].filter((one) => one.kind == "tab");
  const narrow = document.body.classList.contains("narrow");
  if (tabs.length && !tabs.some((one) => one.props.visible && one.props.label == front) && !(narrow && front == "Tree"))
    front = narrow ? "Tree" : tabs.find((one) => one.props.visible)?.props.label;
  for (const { made, props } of tabs) {
    made.button.hidden = !props.visible;
    made.button.setAttribute("aria-selected", props.label == front);
    made.inner.hidden = !(props.visible && props.label == front);
  }
  treeTab.hidden = !narrow;
  treeTab.setAttribute("aria-selected", front == "Tree");
  if (narrow) places.left.hidden = front != "Tree";
}

const treeTab = make("button", { role: "tab", textContent: "Tree", hidden: true, onclick: () => showTab("tree") });
list.append(treeTab);

// Sizes

const sizes = { left: 340, tabs: 340, below: 64, ...page.saved("sizes") };

function setSize(name, size) {
  sizes[name] = Math.round(size);
  document.documentElement.style.setProperty(`--${name}`, `${sizes[name]}px`);
  page.save("sizes", sizes);
}

for (const split of document.querySelectorAll(".split")) {
  const name = split.dataset.of, first = sizes[name] || 300;
  split.onpointerdown = (event) => {
    split.setPointerCapture(event.pointerId);
    document.body.classList.add("dragging");
    const [x, y, size] = [event.clientX, event.clientY, sizes[name]];
    split.onpointermove = (move) => {
      const by = name == "left" ? move.clientX - x : name == "tabs" ? x - move.clientX : y - move.clientY;
      const most = name == "below" ? innerHeight / 2 : innerWidth * 0.45;
      setSize(name, Math.min(Math.max(size + by, 0), most));
    };
  };
  split.onpointerup = split.onpointercancel = () => { split.onpointermove = null; document.body.classList.remove("dragging"); };
  split.ondblclick = () => setSize(name, sizes[name] < 20 ? first : 0);
}

function layout() {
  const narrow = innerWidth < NARROW;
  document.body.classList.toggle("narrow", narrow);
  (narrow ? places.tabs : left).append(places.left);
  if (!narrow) {
    places.left.hidden = false;
    // The scene keeps at least 40 % of the width.
    const share = Math.min(1, 0.6 * innerWidth / Math.max(sizes.left + sizes.tabs, 1));
    for (const name of ["left", "tabs"]) document.documentElement.style.setProperty(`--${name}`, `${Math.round(sizes[name] * share)}px`);
  }
  drawTabs();
  for (const one of page.elements.values()) dirty.add(one);
  redraw();
}
addEventListener("resize", layout);
setSize("below", sizes.below);

// Light and dark

const prefersDark = matchMedia("(prefers-color-scheme: dark)");
function theme() {
  const name = page.saved("theme") ?? (prefersDark.matches ? "dark" : "light");
  document.documentElement.dataset.theme = name;
  const scene = byId("scene").contentDocument?.documentElement;
  if (scene) scene.dataset.theme = name;
  for (const one of page.elements.values()) dirty.add(one);
  redraw();
}
prefersDark.addEventListener("change", theme);
byId("theme").onclick = () => {
  page.save("theme", document.documentElement.dataset.theme == "dark" ? "light" : "dark");
  theme();
};

// Keys. A button or box gives the focus back after a click: the keys are those of the page then.

const TYPING = "input:not([type=checkbox]), select, textarea";  // take all keys themselves

function keydown(event) {
  if (event.target.closest(TYPING) || event.ctrlKey || event.metaKey || event.altKey || event.defaultPrevented) return;
  const own = event.target.closest("button, a, input, summary");  // focused by the Tab key
  if (event.key == "/") { event.preventDefault(); document.querySelector(".treetools input")?.focus(); }
  else if (own) return;
  else if (event.key == " ") { event.preventDefault(); document.querySelector("#bar .primary:not([hidden]), #bar .run:not([hidden])")?.click(); }
  else page.first("tree")?.made.key(event);
}
addEventListener("keydown", keydown);
addEventListener("click", (event) => {
  const used = event.target.closest("button, a, input[type=checkbox]");
  if (used && event.detail) used.blur();  // not after a key
});

// The connection

let socket;
function connect() {
  socket = new WebSocket(`${location.protocol == "https:" ? "wss" : "ws"}://${location.host}/page`, "bt-manip");
  socket.onopen = () => { byId("lost").hidden = true; };
  socket.onmessage = (event) => { apply(JSON.parse(event.data)); setTimeout(showScene, 50); };
  socket.onclose = () => { byId("lost").hidden = false; setTimeout(connect, 1000); };
}
// The scene's script keeps the browser busy for a second: it comes after the rest is painted.
function showScene() { if (!byId("scene").hasAttribute("src")) byId("scene").src = "scene"; }
byId("scene").onload = () => {
  theme();
  // The scene has keys of its own: W, A, S, D and arrows move its camera.
  byId("scene").contentWindow.addEventListener("keydown", (event) => { if (event.key == "/" || event.key == " ") keydown(event); });
};
theme();
layout();
connect();
