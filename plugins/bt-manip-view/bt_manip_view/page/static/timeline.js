"use strict";
// The timeline: a lane for each robot, coloured by its running leaf, with marks; a click shows that time.

const WINDOW = 60;  // simulated time shown of a run that goes on [s]
const SHORTEST = 0.05;  // shortest time that fills the width [s]

function hue(name) {
  let hash = 7;
  for (const letter of name) hash = (hash * 31 + letter.codePointAt(0)) % 3600;
  return (hash * 137) % 360;
}

function makeTimeline(element, page) {
  const p = element.props;
  const canvas = make("canvas", { tabIndex: 0, role: "slider", ariaLabel: "Timeline" });
  const button = (textContent, title, onclick) => make("button", { textContent, title, onclick });
  const live = button("Back to now", "Show the present", () => seek(null));
  const tools = make("div", { className: "zoom" }, live,
    button("−", "Show a longer time (wheel)", () => zoom(2)), button("+", "Show a shorter time (wheel)", () => zoom(0.5)),
    button("Whole run", "Show the whole run; Shift and drag: choose a range", () => choose(p.start, null)));
  const node = make("div", { className: "timeline" }, canvas, tools);
  const [left, right, top] = [8, 8, 18];
  let chosen = null;  // the range [s], to the end of the run without its end; null: the last minute, or a run that has ended
  let asked = null;  // time of a link, until it is sent [s]
  let held = null;  // what the pressed mouse does: "seek", or where a range starts [s]

  // Range and time, which are in the address of the page

  const last = () => Math.max(p.end ?? p.time, p.start + (p.end === null ? 5 : 1e-3));
  const range = () => chosen ? [chosen[0], chosen[1] ?? last()] : [p.end === null ? Math.max(p.start, p.time - WINDOW) : p.start, last()];

  function choose(from, to) {
    chosen = [Math.max(from, p.start), to === null || to >= last() ? null : Math.max(to, from + SHORTEST)];
    link({ from: chosen[0], to: chosen[1] });
    draw();
  }

  function zoom(factor, about = p.shown ?? p.time) {
    const [a, b] = range(), t = Math.min(Math.max(about, a), b), f = Math.max(factor, SHORTEST / (b - a));
    choose(t - (t - a) * f, t + (b - t) * f);
  }

  function seek(time) {
    const [a, b] = range();
    if (chosen && time !== null && (time < a || time > b)) choose(time - (b - a) / 2, time + (b - a) / 2);
    element.send("seek", time);
    link({ at: time });
  }

  // Few decimals would name the state after the one that is shown.
  function link(values) {
    const parts = new URLSearchParams(location.hash.slice(1));
    for (const [name, value] of Object.entries(values)) value === null ? parts.delete(name) : parts.set(name, +value.toFixed(6));
    history.replaceState(null, "", parts.size ? `#${parts}` : location.pathname);
  }

  function follow() {
    const parts = new URLSearchParams(location.hash.slice(1)), number = (name) => parts.has(name) ? Number(parts.get(name)) : null;
    chosen = parts.has("from") ? [number("from"), number("to")] : null;
    asked = number("at");
    if (chosen?.some(Number.isNaN)) chosen = null;
  }
  follow();
  addEventListener("hashchange", () => { follow(); draw(); });

  // Drawing

  const x = (t) => { const [a, b] = range(); return left + (t - a) / (b - a) * (canvas.clientWidth - left - right); };
  const time = (px) => {
    const [a, b] = range(), t = a + (px - left) / Math.max(canvas.clientWidth - left - right, 1) * (b - a);
    return Math.min(Math.max(t, a), b, p.end ?? p.time);
  };

  function drawLeaves(c, start, end, bottom, dark) {
    const robots = p.robots.length > 1 ? p.robots : [""], high = (bottom - top) / robots.length;
    const next = {};  // when the leaf of a robot ends [s]
    const bars = [...p.leaves].reverse().map(([t, uid, name, robot]) => {
      const until = next[robot] ?? (p.end ?? p.time);
      next[robot] = t;
      return { t, uid, name, robot, until };
    });
    bars.sort((one, other) => Boolean(one.robot) - Boolean(other.robot));  // leaves without a robot are below the others
    for (const { t, uid, name, robot, until } of bars) {
      if (!uid || until < start || t > end) continue;
      const lane = robots.length > 1 ? robots.indexOf(robot) : 0;
      const [y, height] = lane < 0 ? [top, bottom - top] : [top + lane * high, high - (robots.length > 1)];
      const from = x(Math.max(t, start)), to = x(Math.min(until, end));
      c.fillStyle = `hsl(${hue(name)} 55% ${dark ? 38 : 72}%)`;
      c.fillRect(from, y, Math.max(to - from, 1), height);
      if (to - from > 7 * name.length) { c.fillStyle = colour("--text"); c.fillText(name, from + 3, y + height / 2 + 4); }
    }
    c.fillStyle = colour("--text");
    if (robots.length > 1) robots.forEach((name, lane) => {
      const width = c.measureText(name).width + 6, y = top + lane * high;
      c.globalAlpha = 0.75; c.fillStyle = colour("--panel"); c.fillRect(canvas.clientWidth - right - width, y + 1, width, high - 3);
      c.globalAlpha = 1; c.fillStyle = colour("--text"); c.fillText(name, canvas.clientWidth - right - width + 3, y + high / 2 + 4);
    });
  }

  function draw() {
    if (asked !== null) { element.send("seek", asked); asked = null; }
    const [start, end] = range(), now = p.shown ?? p.time;
    live.hidden = p.shown === null;
    canvas.setAttribute("aria-valuenow", now.toFixed(2));
    canvas.setAttribute("aria-valuetext", `${now.toFixed(2)} s`);
    Object.assign(canvas.dataset, { range: `${start.toFixed(3)} ${end.toFixed(3)}`, lanes: p.robots.join(" ") });
    if (p.shown === null) delete canvas.dataset.shown; else canvas.dataset.shown = p.shown;
    const { context: c, width, height } = sized(canvas);
    if (!width) return;
    const dark = document.documentElement.dataset.theme == "dark", bottom = height - 14;
    c.font = "11px system-ui";
    c.fillStyle = colour("--hover");
    c.fillRect(left, top, width - left - right, bottom - top);
    drawLeaves(c, start, end, bottom, dark);
    const steps = [0.01, 0.02, 0.05, 0.1, 0.2, 0.5, 1, 2, 5, 10, 20, 60, 120, 300, 600, 3600].find((s) => (end - start) / s < width / 70) ?? end;
    c.fillStyle = colour("--dim");
    for (let t = Math.ceil(start / steps) * steps; t <= end; t += steps) c.fillText(`${+t.toFixed(2)} s`, x(t), height - 2);
    for (const [t, kind, text] of p.marks) {
      if (t < start || t > end) continue;
      c.fillStyle = c.strokeStyle = kind == "cycle" ? colour("--dim") : "#e03131";
      const at = x(t);
      c.beginPath();
      if (kind == "failure") { c.moveTo(at - 5, top - 9); c.lineTo(at + 5, top - 9); c.lineTo(at, top); c.fill(); }
      else if (kind == "breakpoint") { c.arc(at, top - 5, 4, 0, 7); c.fill(); }
      else { c.moveTo(at, 2); c.lineTo(at, bottom); c.stroke(); c.fillText(text, at + 3, 11); }
    }
    if (typeof held == "number") { c.globalAlpha = 0.3; c.fillStyle = colour("--blue"); c.fillRect(x(held), top, x(to) - x(held), bottom - top); c.globalAlpha = 1; }
    if (now < start || now > end) return;
    c.strokeStyle = c.fillStyle = colour("--blue"); c.lineWidth = 2;
    c.beginPath(); c.moveTo(x(now), 0); c.lineTo(x(now), bottom + 3); c.stroke();
    c.lineWidth = 1;
  }

  // Input events

  let to = 0;  // where the range that is being chosen ends [s]
  const isNow = (at) => p.end === null && at >= p.time;  // at the right edge of a run that goes on
  canvas.onpointerdown = (event) => {
    canvas.setPointerCapture(event.pointerId);
    held = event.shiftKey ? (to = time(event.offsetX)) : "seek";
    if (held === "seek") canvas.onpointermove(event);
  };
  canvas.onpointerup = () => {
    const from = held;
    held = null;
    if (typeof from == "number" && from != to) choose(Math.min(from, to), Math.max(from, to));
  };
  canvas.onpointermove = (event) => {
    const at = time(event.offsetX);
    if (held === "seek") return seek(isNow(at) ? null : at);
    if (held !== null) { to = at; return draw(); }
    const near = p.marks.filter(([t, kind]) => kind != "cycle" && Math.abs(x(t) - event.offsetX) < 6).map((one) => one[2]);
    const running = {};
    for (const [t, , name, robot] of p.leaves) if (t <= at) running[robot] = name;
    const leaves = Object.entries(running).filter(([, name]) => name).map(([robot, name]) => p.robots.length > 1 && robot ? `${robot}: ${name}` : name);
    canvas.title = [`${at.toFixed(2)} s  ${leaves.join(", ")}`, ...near.slice(0, 5)].join("\n");
  };
  canvas.onwheel = (event) => {
    event.preventDefault();
    const [a, b] = range(), sideways = event.deltaX || (event.shiftKey ? event.deltaY : 0);
    if (!sideways) return zoom(Math.exp(event.deltaY * 2e-3), time(event.offsetX));
    const by = Math.min(Math.max(sideways * (b - a) / 1000, p.start - a), Math.max(last() - b, 0));
    choose(a + by, b + by);
  };
  canvas.onkeydown = (event) => {
    const [start, end] = range(), step = Math.min(0.1, Math.max(0.01, (end - start) / 50));
    const steps = { ArrowLeft: -step, ArrowRight: step, PageUp: -10 * step, PageDown: 10 * step };
    const now = p.shown ?? p.time;
    const at = event.key == "Home" ? start : event.key == "End" ? end : now + steps[event.key];
    if (!Number.isFinite(at)) return;
    event.preventDefault();
    seek(isNow(at) ? null : Math.min(Math.max(at, p.start), p.end ?? p.time));
  };
  new ResizeObserver(draw).observe(canvas);
  return { node, draw, seek, range };
}
