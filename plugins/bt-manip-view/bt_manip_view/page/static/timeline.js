"use strict";
// The timeline: coloured by the running leaf, with marks; a click shows that time.

const WINDOW = 60;  // simulated time shown for a run [s]

function hue(name) {
  let hash = 7;
  for (const letter of name) hash = (hash * 31 + letter.codePointAt(0)) % 3600;
  return (hash * 137) % 360;
}

function makeTimeline(element, page) {
  const node = Object.assign(document.createElement("div"), { className: "timeline" });
  const canvas = document.createElement("canvas");
  canvas.tabIndex = 0;
  canvas.setAttribute("role", "slider");
  canvas.setAttribute("aria-label", "Timeline");
  const live = Object.assign(document.createElement("button"), { textContent: "Back to now", hidden: true });
  live.onclick = () => element.send("seek", null);
  node.append(canvas, live);
  const [left, right, top] = [8, 8, 18];

  const range = () => {
    const p = element.props;
    if (p.end !== null) return [p.start, Math.max(p.end, p.start + 1e-3)];
    return [Math.max(0, p.time - WINDOW), Math.max(p.time, 5)];
  };
  const x = (t) => { const [a, b] = range(); return left + (t - a) / (b - a) * (canvas.clientWidth - left - right); };
  const time = (px) => {
    const [a, b] = range(), t = a + (px - left) / Math.max(canvas.clientWidth - left - right, 1) * (b - a);
    return Math.min(Math.max(t, a), element.props.end ?? element.props.time);
  };

  function draw() {
    const p = element.props, [start, end] = range(), now = p.shown ?? p.time;
    live.hidden = p.shown === null;
    canvas.setAttribute("aria-valuenow", now.toFixed(2));
    canvas.setAttribute("aria-valuetext", `${now.toFixed(2)} s`);
    const { context: c, width, height } = sized(canvas);
    if (!width) return;
    const dark = document.documentElement.dataset.theme == "dark", bottom = height - 14;
    c.font = "11px system-ui";
    c.fillStyle = colour("--hover");
    c.fillRect(left, top, width - left - right, bottom - top);
    p.leaves.forEach(([t, uid, name], i) => {
      const until = p.leaves[i + 1]?.[0] ?? (p.end ?? p.time);
      if (!uid || until < start) return;
      const from = x(Math.max(t, start)), to = x(until);
      c.fillStyle = `hsl(${hue(name)} 55% ${dark ? 38 : 72}%)`;
      c.fillRect(from, top, Math.max(to - from, 1), bottom - top);
      if (to - from > 7 * name.length) { c.fillStyle = colour("--text"); c.fillText(name, from + 3, (top + bottom) / 2 + 4); }
    });
    const steps = [0.1, 0.2, 0.5, 1, 2, 5, 10, 20, 60, 120, 300, 600, 3600].find((s) => (end - start) / s < width / 70) ?? end;
    c.fillStyle = colour("--dim");
    for (let t = Math.ceil(start / steps) * steps; t <= end; t += steps) c.fillText(`${+t.toFixed(2)} s`, x(t), height - 2);
    for (const [t, kind, text] of p.marks) {
      if (t < start) continue;
      c.fillStyle = c.strokeStyle = kind == "cycle" ? colour("--dim") : "#e03131";
      const at = x(t);
      c.beginPath();
      if (kind == "failure") { c.moveTo(at - 5, top - 9); c.lineTo(at + 5, top - 9); c.lineTo(at, top); c.fill(); }
      else if (kind == "breakpoint") { c.arc(at, top - 5, 4, 0, 7); c.fill(); }
      else { c.moveTo(at, 2); c.lineTo(at, bottom); c.stroke(); c.fillText(text, at + 3, 11); }
    }
    c.strokeStyle = c.fillStyle = colour("--blue"); c.lineWidth = 2;
    c.beginPath(); c.moveTo(x(now), 0); c.lineTo(x(now), bottom + 3); c.stroke();
    c.lineWidth = 1;
  }

  let held = false;
  const seek = (event) => element.send("seek", time(event.offsetX));
  canvas.onpointerdown = (event) => { held = true; canvas.setPointerCapture(event.pointerId); seek(event); };
  canvas.onpointerup = () => { held = false; };
  canvas.onpointermove = (event) => {
    if (held) return seek(event);
    const at = time(event.offsetX), p = element.props;
    const near = p.marks.filter(([t, kind]) => kind != "cycle" && Math.abs(x(t) - event.offsetX) < 6).map((one) => one[2]);
    const leaf = p.leaves.filter(([t]) => t <= at).at(-1)?.[2] ?? "";
    canvas.title = [`${at.toFixed(2)} s  ${leaf}`, ...near.slice(0, 5)].join("\n");
  };
  canvas.onkeydown = (event) => {
    const steps = { ArrowLeft: -0.1, ArrowRight: 0.1, PageUp: -1, PageDown: 1 };
    const now = element.props.shown ?? element.props.time, [start, end] = range();
    const to = event.key == "Home" ? start : event.key == "End" ? end : now + steps[event.key];
    if (!Number.isFinite(to)) return;
    event.preventDefault();
    element.send("seek", Math.min(Math.max(to, start), end));
  };
  new ResizeObserver(draw).observe(canvas);
  return { node, draw };
}
