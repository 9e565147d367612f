"use strict";
(() => {
  const data = JSON.parse(document.getElementById("data").textContent);
  const words = JSON.parse(document.getElementById("words").textContent);
  const byId = (id) => document.getElementById(id);
  const [picture, chart, slider, play, factor] = ["picture", "chart", "slider", "play", "factor"].map(byId);
  const states = ["open", "stick", "slip", "hair"];
  const fell = states.length;  // joints of what has fallen are not drawn
  const colours = ["#0072b2", "#d55e00"];
  let model = 0, timer = null, bodies = [], joints = [], damaged = [], ties = [];

  // a phrase with its places filled; numbers as the language of the page writes them
  const local = (number) => document.documentElement.lang === "en" ? String(number) : String(number).replace(".", ",");
  const filled = (phrase, values) => phrase.replace(/{(\w+)}/g, (_, name) => values[name]);

  function element(parent, name, attributes, text) {
    const made = document.createElementNS("http://www.w3.org/2000/svg", name);
    for (const [key, value] of Object.entries(attributes)) made.setAttribute(key, value);
    if (text !== undefined) made.textContent = text;
    return parent.appendChild(made);
  }

  function displacements(frame) {
    if (!frame.values) {
      const bytes = Uint8Array.from(atob(frame.displacements), (letter) => letter.charCodeAt(0));
      const view = new DataView(bytes.buffer);
      frame.values = Float64Array.from({ length: bytes.length / 2 }, (_, k) => frame.scale * view.getInt16(2 * k, true));
    }
    return frame.values;
  }

  const largest = (frame) => displacements(frame).reduce((most, value) => Math.max(most, Math.abs(value)), 0);
  const bounds = (points) => [0, 1].map((axis) => [Math.min(...points.map((p) => p[axis])), Math.max(...points.map((p) => p[axis]))]);

  function readable(drawn, most) {  // 1, 2 or 5 times a power of ten, at least 1
    if (!(most > 0) || drawn <= most) return 1;
    const power = 10 ** Math.floor(Math.log10(drawn / most));
    return Math.max(...[1, 2, 5].filter((step) => step * power <= drawn / most * (1 + 1e-9))) * power;
  }

  // one factor for the whole run, of all models: what moves between two increments then is the wall, not the scale
  const automatic = Math.min(...data.models.map((shown) => {
    const [low, high] = bounds(shown.nodes)[1];
    return readable(0.06 * (high - low), Math.max(...shown.frames.map(largest)));
  }));

  function choose(number) {
    model = number;
    const shown = data.models[model];
    for (const [k, button] of [...byId("models").children].entries()) button.setAttribute("aria-pressed", String(k === model));
    const nodes = shown.nodes;
    const [xs, ys] = bounds(nodes.concat(...shown.supports));
    const margin = 0.12 * Math.max(xs[1] - xs[0], ys[1] - ys[0]);
    picture.setAttribute("viewBox", [xs[0] - margin, -ys[1] - margin, xs[1] - xs[0] + 2 * margin, ys[1] - ys[0] + 1.2 * margin].join(" "));
    picture.replaceChildren();
    for (const ring of shown.supports) element(picture, "path", { class: "support", d: "M" + ring.map((p) => `${p[0]} ${-p[1]}`).join("L") + "Z" });
    bodies = shown.bodies.map(() => element(picture, "path", { class: "body", "fill-rule": "evenodd" }));
    damaged = Array.from({ length: 9 }, (_, k) => element(picture, "path", { class: "joint damage", "stroke-opacity": (k + 1) / 9 }));
    joints = states.map((name) => element(picture, "path", { class: `joint ${name}` }));
    picture.append(joints[1], joints[3], joints[2], joints[0]);
    ties = shown.ties.map(() => element(picture, "line", {}));
    byId("tied").hidden = !ties.length;
    byId("fell").hidden = !shown.frames.some((frame) => frame.fallen.length);
    byId("damaged").hidden = !shown.frames.some((frame) => frame.damage);
    slider.max = shown.frames.length - 1;
    const peak = shown.frames.reduce((best, frame, k) => (frame.shear > shown.frames[best].shear ? k : best), 0);
    slider.value = peak;
    byId("thinned").textContent = filled(shown.frames.length < shown.increments ? words.thinned : words.all,
      { shown: shown.frames.length, all: shown.increments });
    draw();
  }

  function draw() {
    const shown = data.models[model], frame = shown.frames[Number(slider.value)], u = displacements(frame);
    const times = factor.value === "auto" ? automatic : Number(factor.value);
    const at = shown.nodes.map((p, k) => [p[0] + times * u[2 * k], -(p[1] + times * u[2 * k + 1])]);
    const text = (p) => `${p[0].toFixed(5)} ${p[1].toFixed(5)}`;
    const middle = (a, b) => [0.5 * (at[a][0] + at[b][0]), 0.5 * (at[a][1] + at[b][1])];
    shown.bodies.forEach((loops, k) => bodies[k].setAttribute("d", loops.map((loop) => "M" + loop.map((n) => text(at[n])).join("L") + "Z").join("")));
    bodies.forEach((path, k) => path.setAttribute("class", frame.fallen.includes(k) ? "fell" : "body"));
    const lines = ["", "", "", ""], count = [0, 0, 0, 0], bands = Array(10).fill("");
    shown.pieces.forEach(([before, node, after], k) => {
      const state = Number(frame.status[k]);
      if (state === fell) return;
      count[state] += 1;
      const line = "M" + text(middle(before, node)) + "L" + text(at[node]) + "L" + text(middle(node, after));
      lines[state] += line;
      bands[Number(frame.damage[k] ?? 0)] += line;
    });
    lines.forEach((line, k) => joints[k].setAttribute("d", line));
    damaged.forEach((path, k) => path.setAttribute("d", bands[k + 1]));
    ties.forEach((line, k) => {
      line.setAttribute("class", `tie ${frame.ties[k].state}`);
      shown.ties[k].forEach(([x, y], end) => {
        const [u, v] = frame.ties[k].moved[end];
        line.setAttribute(`x${end + 1}`, x + times * u);
        line.setAttribute(`y${end + 1}`, -(y + times * v));
      });
    });
    const pulls = frame.ties.map((tie) => local((tie.force / 1e3).toPrecision(4))).join("; ");
    const broken = [...frame.damage].filter((digit) => digit === "9").length, some = [...frame.damage].filter((digit) => digit !== "0").length;
    const said = filled(words.state, {
      number: frame.increment, phase: frame.row === 0 ? words.gravity : words[frame.phase] ?? frame.phase,
      multiplier: local(frame.multiplier.toFixed(4)), shear: local((frame.shear / 1e3).toPrecision(4)),
      moved: local((1e3 * frame.moved).toPrecision(4)), open: count[0] + count[3], hair: count[3],
      limit: local("0.01"), slip: count[2], points: count.reduce((all, one) => all + one, 0),
    });
    byId("state").textContent = said + (pulls ? filled(words.ties, { forces: pulls }) : "") + (some ? filled(words.damaged, { some, broken }) : "") + filled(words.drawn, { times });
    mark(frame);
  }

  const limits = Object.entries(data.limit), dashes = { associative: "2 3", headline: "7 3" };
  const box = { left: 58, right: 426, top: 14, bottom: 284 };
  const axes = (() => {
    const all = data.curves.flatMap((curve) => curve.y), ends = data.curves.flatMap((curve) => curve.at_rest);
    const [low, high] = [Math.min(...ends) * 1.02, Math.max(...ends) * 1.02];
    return { low, high: high > low ? high : 1, y: Math.max(...all, ...limits.map(([, shear]) => shear / 1e3)) * 1.08 || 1 };
  })();
  const across = (x) => box.left + Math.max(0, Math.min((x - axes.low) / (axes.high - axes.low), 1)) * (box.right - box.left);
  const up = (y) => box.bottom - (y / axes.y) * (box.bottom - box.top);

  function ticks(least, most) {
    const raw = (most - least) / 5, power = 10 ** Math.floor(Math.log10(raw));
    const step = [1, 2, 5, 10].map((k) => k * power).find((value) => value >= raw);
    const first = Math.ceil(least / step - 1e-9), count = Math.floor(most / step + 1e-9) - first + 1;
    return Array.from({ length: count }, (_, k) => Number(((first + k) * step).toPrecision(6)));
  }

  function drawChart() {
    for (const x of ticks(axes.low, axes.high)) {
      element(chart, "line", { x1: across(x), x2: across(x), y1: box.top, y2: box.bottom, stroke: "#e6e9ec" });
      element(chart, "text", { x: across(x), y: box.bottom + 16, "text-anchor": "middle" }, local(x));
    }
    for (const y of ticks(0, axes.y)) {
      element(chart, "line", { x1: box.left, x2: box.right, y1: up(y), y2: up(y), stroke: "#e6e9ec" });
      element(chart, "text", { x: box.left - 6, y: up(y) + 4, "text-anchor": "end" }, local(y));
    }
    element(chart, "path", { d: `M${box.left} ${box.top}V${box.bottom}H${box.right}`, fill: "none", stroke: "#5d6873" });
    element(chart, "text", { x: 0.5 * (box.left + box.right), y: 320, "text-anchor": "middle" }, words.across);
    element(chart, "text", { transform: `translate(14 ${0.5 * (box.top + box.bottom)}) rotate(-90)`, "text-anchor": "middle" }, words.up);
    const names = [...data.models.map((shown) => shown.name), ...limits.map(([name]) => words[name])];
    const wide = (name) => 6.6 * name.length;
    const leftmost = box.left + 10; // where the names stand, if the curves go back from the right end
    const start = axes.high < -axes.low ? leftmost : Math.max(box.right - Math.max(162, 34 + Math.max(...names.map(wide))), leftmost);
    const room = box.right - start - 32;
    const fitted = (name) => (wide(name) > room ? { textLength: room, lengthAdjust: "spacingAndGlyphs" } : {});
    const entry = (row) => box.bottom - 14 - 16 * (data.curves.length + limits.length - 1 - row);
    data.curves.forEach((curve, k) => {
      const line = curve.x.map((x, row) => `${across(x).toFixed(2)} ${up(curve.y[row]).toFixed(2)}`).join("L");
      element(chart, "path", { d: "M" + line, fill: "none", stroke: colours[k % 2], "stroke-width": 2, "stroke-dasharray": k ? "6 3" : "none" });
      const y = entry(k);
      element(chart, "path", { d: `M${start} ${y - 4}h26`, fill: "none", stroke: colours[k % 2], "stroke-width": 2, "stroke-dasharray": k ? "6 3" : "none" });
      element(chart, "text", { x: start + 32, y, ...fitted(data.models[k].name) }, data.models[k].name);
    });
    limits.forEach(([name, shear], k) => {
      const line = { stroke: "#333", "stroke-dasharray": dashes[name], fill: "none", class: name }, y = entry(data.curves.length + k);
      element(chart, "path", { d: `M${box.left} ${up(shear / 1e3)}H${box.right}`, ...line });
      element(chart, "path", { d: `M${start} ${y - 4}h26`, ...line });
      element(chart, "text", { x: start + 32, y, ...fitted(words[name]) }, words[name]);
    });
    return element(chart, "circle", { id: "point", r: 6, stroke: "#fff", "stroke-width": 2 });
  }

  const point = drawChart();
  function mark(frame) {
    point.setAttribute("cx", across(1e3 * frame.moved).toFixed(2));
    point.setAttribute("cy", up(frame.shear / 1e3).toFixed(2));
    point.setAttribute("fill", colours[model % 2]);
  }

  function stop() {
    clearInterval(timer);
    timer = null;
    play.textContent = words.play;
  }

  data.models.forEach((shown, k) => {
    const button = document.createElement("button");
    button.type = "button";
    button.textContent = shown.name;
    button.addEventListener("click", () => { stop(); choose(k); });
    byId("models").append(button);
  });
  for (const value of ["auto", 1, 2, 5, 10, 20, 50, 100, 200, 500, 1000]) {
    const option = document.createElement("option");
    option.value = value;
    option.textContent = value === "auto" ? filled(words.automatic, { factor: automatic }) : value;
    factor.append(option);
  }
  slider.addEventListener("input", () => { stop(); draw(); });
  factor.addEventListener("change", draw);
  play.addEventListener("click", () => {
    if (timer) return stop();
    if (slider.value === slider.max) slider.value = 0;
    play.textContent = words.stop;
    timer = setInterval(() => {
      slider.value = Number(slider.value) + 1;
      draw();
      if (slider.value === slider.max) stop();
    }, 90);
  });
  choose(0);
})();
