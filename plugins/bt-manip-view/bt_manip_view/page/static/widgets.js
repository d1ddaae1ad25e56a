"use strict";
// The elements of the page: one maker per kind. A maker returns the DOM node, and functions that
// draw it; `send(event, value)` notifies the server. All text is set as text, except `html`.

const make = (tag, props = {}, ...children) => {
  const node = Object.assign(document.createElement(tag), props);
  node.append(...children);
  return node;
};

let inputs = 0;

function row(element, input, ...more) {
  const p = element.props;
  input.id = `input${++inputs}`;
  const label = make("label", { htmlFor: input.id });
  const node = make("div", { className: "row", title: p.hint || "" }, label, input, ...more);
  return { node, draw() {
    label.textContent = p.label;
    for (const one of [input, ...more]) one.disabled = p.disabled;
  } };
}

function numeric(element, input) {
  // An input for a number, which follows the value unless it is being edited.
  const p = element.props;
  input.type = "number";
  if (p.min !== null) input.min = p.min;
  if (p.max !== null) input.max = p.max;
  input.step = p.step ?? "any";
  input.onchange = () => {
    const value = Math.min(Math.max(Number(input.value), p.min ?? -Infinity), p.max ?? Infinity);
    if (input.value !== "" && Number.isFinite(value)) element.send("value", value);
  };
  input.onkeydown = (event) => { if (event.key == "Enter") input.blur(); };
  return () => { if (document.activeElement !== input) input.value = p.value; };
}

const WIDGETS = {
  html(element) {
    const node = make("div", { className: "html" });
    return { node, draw() { node.innerHTML = element.props.content; } };
  },
  folder(element) {
    const node = make("div", { className: "folder" });
    if (!element.props.label) return { node, inner: node };
    const inner = make("details", { open: true }, make("summary", { textContent: element.props.label }));
    node.append(inner);
    return { node, inner };
  },
  button(element) {
    const p = element.props;
    const node = make("button", { className: p.style, title: p.hint });
    node.onclick = () => element.send("click", null);
    return { node, draw() { node.textContent = p.label; node.disabled = p.disabled; } };
  },
  download(element) {
    const p = element.props;
    const node = make("a", { className: "button", title: p.hint, download: "" });
    return { node, draw() {
      node.textContent = p.label;
      node.setAttribute("aria-disabled", p.disabled);
      if (p.disabled) node.removeAttribute("href"); else node.href = p.path;
    } };
  },
  button_group(element) {
    const p = element.props;
    const buttons = p.options.map((option) => make("button", {
      textContent: option, onclick: () => element.send("click", option),
    }));
    const label = p.label ? [make("label", { textContent: p.label })] : [];
    const node = make("div", { className: "row", title: p.hint }, ...label, ...buttons);
    return { node, draw() { for (const one of buttons) one.disabled = p.disabled; } };
  },
  checkbox(element) {
    const input = make("input", { type: "checkbox" });
    const made = row(element, input);
    input.onchange = () => element.send("value", input.checked);
    return { node: made.node, draw() { made.draw(); input.checked = element.props.value; } };
  },
  dropdown(element) {
    const p = element.props;
    const input = make("select");
    const made = row(element, input);
    made.node.classList.add("wide");
    let options = null;
    input.onchange = () => element.send("value", input.value);
    return { node: made.node, draw() {
      made.draw();
      if (options !== p.options) {
        options = p.options;
        input.replaceChildren(...options.map((one) => make("option", { value: one, textContent: one })));
      }
      input.value = p.value;
    } };
  },
  text(element) {
    const input = make("input", { type: "text", maxLength: 10000 });
    const made = row(element, input);
    input.oninput = () => element.send("value", input.value);
    return { node: made.node, draw() {
      made.draw();
      if (document.activeElement !== input) input.value = element.props.value;
    } };
  },
  number(element) {
    const input = make("input");
    const made = row(element, input), follow = numeric(element, input);
    return { node: made.node, draw() { made.draw(); follow(); } };
  },
  slider(element) {
    const p = element.props;
    const input = make("input", { type: "range", min: p.min, max: p.max, step: p.step });
    const field = make("input", { ariaLabel: `${p.label} value` });
    const made = row(element, input, field), follow = numeric(element, field);
    let held = false;
    input.onpointerdown = () => { held = true; };
    input.onpointerup = input.onpointercancel = () => { held = false; };
    input.oninput = () => element.send("value", Number(input.value));
    return { node: made.node, draw() { made.draw(); follow(); if (!held) input.value = p.value; } };
  },
  picture(element) {
    const node = make("img", { className: "picture", alt: "Camera image" });
    return { node, draw() {
      node.hidden = !(element.props.visible && element.props.source);
      if (!node.hidden) node.src = element.props.source;
    } };
  },
  status(element) {
    const p = element.props;
    const task = make("b"), chip = make("span", { className: "chip" });
    const note = make("span", { className: "dim" });
    const node = make("div", { className: "status", role: "status" }, task, chip, note);
    return { node, draw() {
      task.textContent = p.task;
      chip.textContent = chip.title = p.text;
      chip.className = `chip ${p.look}`;
      note.textContent = p.note;
      document.title = p.task ? `${p.task} – bt-manip` : "bt-manip";
    } };
  },
  plot: makePlot,
  blackboard(element) {
    const body = make("table"), node = make("div", {}, body);
    return { node, draw() {
      const entries = Object.entries(element.props.values).filter(([, value]) => value !== null).sort();
      body.replaceChildren(...entries.map(([key, value]) =>
        make("tr", {}, make("td", {}, make("b", { textContent: key })), make("td", { textContent: value }))));
    } };
  },
  result(element) {
    const p = element.props;
    const chip = make("span"), text = make("pre"), node = make("div", {}, make("p", {}, chip), text);
    return { node, draw() {
      chip.className = `chip ${p.status}`;
      chip.textContent = p.status;
      text.textContent = p.text;
    } };
  },
  tree: makeTree,
  node: makeNode,
  timeline: makeTimeline,
  log(element, page) {
    const kinds = { success: true, cycle: true, info: true, warning: true, failure: true, error: true, condition: false };
    Object.assign(kinds, page.saved("log") ?? {});
    const lines = make("div", { className: "loglines" });
    const filters = make("div", { className: "filters" });
    for (const kind in kinds) {
      const box = make("input", { type: "checkbox", checked: kinds[kind] });
      box.onchange = () => { kinds[kind] = box.checked; page.save("log", kinds); drawn = null; draw(); };
      filters.append(make("label", {}, box, ` ${kind}`));
    }
    const node = make("div", { className: "log" }, filters, lines);
    let drawn = null, last = null;  // the drawn lines, and the last of them
    const line = (one) => {
      const [time, kind, text, uid] = one;
      const node = make("div", { className: `logline ${kind}` },
        make("time", { textContent: `${time.toFixed(2)} s` }), make("span", { textContent: text }));
      node.onclick = () => { if (uid) page.select(uid); page.seek(time); };
      return node;
    };
    const draw = () => {
      const all = element.props.lines;
      const first = drawn === all || (last && all.includes(last)) ? all.indexOf(last) + 1 : 0;
      if (first == 0 || drawn === null) lines.replaceChildren();
      const fresh = all.slice(drawn === null ? 0 : first).filter((one) => kinds[one[1]]);
      lines.prepend(...fresh.slice(-500).reverse().map(line));
      while (lines.children.length > 500) lines.lastChild.remove();
      drawn = all; last = all.at(-1) ?? null;
    };
    return { node, draw };
  },
};

function makeNode(element, page) {
  // The selected node, with the values of its ports.
  const node = make("div");
  const draw = () => {
    const tree = page.first("tree"), one = tree && tree.made.find(page.selected);
    if (!one) return node.replaceChildren(make("p", { className: "dim", textContent: "Select a node of the tree." }));
    const [status, message, start, end] = tree.props.states[one.uid] ?? IDLE;
    const values = page.first("blackboard")?.props.values ?? {};
    const kinds = one.kind == one.registration ? one.kind : `${one.kind} ${one.registration}`;
    const broken = tree.props.breakpoints.includes(one.path);
    const took = start === null ? "" : `, ${((end ?? page.time()) - start).toFixed(2)} s`;
    const button = make("button", { textContent: broken ? "Remove breakpoint" : "Set breakpoint" });
    button.onclick = () => tree.send("breakpoint", one.path);
    const ports = (one.ports ?? []).map((port) => make("tr", {},
      make("td", { textContent: port.name }), make("td", { className: "dim", textContent: port.direction }),
      make("td", {}, port.text, ...(port.key ? [make("div", { textContent: `${port.key} = ${values[port.key] ?? "(not set)"}` })] : []))));
    node.replaceChildren(
      make("div", {}, make("b", { textContent: one.path })),
      make("div", { textContent: `${kinds}, ${statusOf(one, status)}${took}` }),
      make("div", { className: status == "FAILURE" && one.kind != "Condition" ? "error" : "note", textContent: message }),
      ...(tree.props.findings[one.uid] ?? []).map(([severity, text]) => make("div", { className: `finding ${severity}`, textContent: `⚠ ${text}` })),
      make("table", {}, ...ports), make("p", {}, button));
  };
  return { node, draw, follows: ["tree", "blackboard"] };
}

const COLOURS = ["#1971c2", "#e67700", "#2b8a3e", "#9c36b5", "#e03131", "#0c8599", "#a17c00", "#868e96"];

function sized(canvas) {
  // A canvas with the resolution of the screen.
  const { width, height } = canvas.getBoundingClientRect(), ratio = window.devicePixelRatio || 1;
  if (canvas.width != Math.round(width * ratio)) canvas.width = Math.round(width * ratio);
  if (canvas.height != Math.round(height * ratio)) canvas.height = Math.round(height * ratio);
  const context = canvas.getContext("2d");
  context.setTransform(ratio, 0, 0, ratio, 0, 0);
  context.clearRect(0, 0, width, height);
  return { context, width, height };
}

const colour = (name) => getComputedStyle(document.documentElement).getPropertyValue(name).trim();

function makePlot(element, page) {
  // Lines over the time range of the timeline, with its cursor; a click shows that time.
  const p = element.props, canvas = make("canvas", { className: "plot" }), legend = make("div", { className: "legend" });
  const close = make("button", { textContent: "×", title: "Remove this plot", ariaLabel: `Remove ${p.label}`, hidden: !p.removable });
  close.onclick = () => element.send("remove", null);
  const lines = p.names.map((name, i) => {
    const line = make("span", { textContent: name });
    line.style.color = COLOURS[i % COLOURS.length];
    return line;
  });
  legend.append(make("b", { textContent: p.unit ? `${p.label} [${p.unit}]` : p.label }), ...lines, close);
  const node = make("div", {}, legend, canvas);
  const [left, right, top, bottom] = [46, 8, 6, 16];

  const range = () => page.first("timeline")?.made.range?.() ?? [p.samples[0]?.[0] ?? 0, p.samples.at(-1)?.[0] ?? 1];
  const timeAt = (px) => { const [a, b] = range(); return a + (px - left) / Math.max(canvas.clientWidth - left - right, 1) * (b - a); };

  function draw() {
    const { context: c, width, height } = sized(canvas), [start, end] = range();
    if (!width) return;
    const samples = p.samples.filter(([t]) => t >= start && t <= end);
    let low = Infinity, high = -Infinity;
    for (const row of samples) for (let i = 1; i < row.length; i++) if (row[i] !== null) { low = Math.min(low, row[i]); high = Math.max(high, row[i]); }
    if (low > high) [low, high] = [0, 1];
    if (low > 0 && low < 0.5 * high) low = 0;
    if (high - low < 1e-9) [low, high] = [low - 0.5, high + 0.5];
    const x = (t) => left + (t - start) / Math.max(end - start, 1e-9) * (width - left - right);
    const y = (v) => height - bottom - (v - low) / (high - low) * (height - top - bottom);
    c.font = "11px system-ui"; c.fillStyle = colour("--dim"); c.strokeStyle = colour("--line"); c.lineWidth = 1;
    for (const value of [low, (low + high) / 2, high]) {
      c.fillText(+value.toPrecision(3), 2, y(value) + 4);
      c.beginPath(); c.moveTo(left, y(value)); c.lineTo(width - right, y(value)); c.stroke();
    }
    c.fillText(`${start.toFixed(1)} s`, left, height - 3);
    c.fillText(`${end.toFixed(1)} s`, width - 42, height - 3);
    p.names.forEach((_, i) => {
      // Of the samples in a column of pixels, the smallest and the largest are drawn.
      c.strokeStyle = COLOURS[i % COLOURS.length]; c.lineWidth = 1.5;
      c.beginPath();
      let column = null, open = false, least, most;
      const go = (value) => { open ? c.lineTo(column, y(value)) : c.moveTo(column, y(value)); open = true; };
      for (const row of samples) {
        const at = Math.round(x(row[0])), value = row[i + 1];
        if (value === null) { if (column !== null) { go(least); go(most); } column = null; open = false; continue; }
        if (at !== column) {
          if (column !== null) { go(least); go(most); }
          column = at; least = most = value;
        } else { least = Math.min(least, value); most = Math.max(most, value); }
      }
      if (column !== null) { go(least); go(most); }
      c.stroke();
    });
    c.strokeStyle = colour("--blue"); c.lineWidth = 1;
    c.beginPath(); c.moveTo(x(page.time()), 0); c.lineTo(x(page.time()), height - bottom); c.stroke();
  }

  canvas.onclick = (event) => page.seek(timeAt(event.offsetX));
  canvas.onpointermove = (event) => {
    const at = timeAt(event.offsetX), row = p.samples.findLast(([t]) => t <= at);
    canvas.title = row ? [`${row[0].toFixed(2)} s`, ...p.names.map((name, i) => `${name} ${row[i + 1] ?? "-"}`)].join("\n") : "";
  };
  new ResizeObserver(draw).observe(canvas);
  return { node, draw, follows: ["timeline"] };
}
