"use strict";
(() => {
  const data = JSON.parse(document.getElementById("data").textContent);
  const byId = (id) => document.getElementById(id);
  const canvas = byId("scene"), slider = byId("slider"), play = byId("play");
  const gl = canvas.getContext("webgl", { antialias: true, preserveDrawingBuffer: true });
  if (!gl) { byId("failed").hidden = false; canvas.hidden = true; return; }

  // every corner carries its block's centroid, translation and rotation: the slider moves all blocks on the graphics card
  const vertexShader = `
    attribute vec3 position, normal, colour, centre, shift, turn;
    uniform mat4 view; uniform vec3 lamp; uniform float part, towards;
    varying vec3 tint;
    vec3 turned(vec3 v, vec3 w) {
      float a = length(w);
      if (a < 1e-7) return v;
      vec3 k = w / a;
      return v * cos(a) + cross(k, v) * sin(a) + k * dot(k, v) * (1.0 - cos(a));
    }
    vec3 carried(vec3 v, vec3 w) {
      float a = length(w);
      if (a < 1e-4) return v;
      vec3 c = cross(w, v);
      return v + (1.0 - cos(a)) / (a * a) * c + (a - sin(a)) / (a * a * a) * cross(w, c);
    }
    void main() {
      vec3 w = part * turn;
      vec3 place = centre + turned(position - centre, w) + carried(part * shift, w);
      gl_Position = view * vec4(place, 1.0);
      gl_Position.z -= towards * gl_Position.w;
      vec3 n = turned(normal, w);
      float light = length(normal) < 0.5 ? 1.0 : 0.58 + 0.42 * max(0.0, dot(n, lamp));
      tint = colour * light;
    }`;
  const fragmentShader = "precision mediump float; varying vec3 tint; void main() { gl_FragColor = vec4(tint, 1.0); }";
  const program = gl.createProgram();
  for (const [kind, text] of [[gl.VERTEX_SHADER, vertexShader], [gl.FRAGMENT_SHADER, fragmentShader]]) {
    const shader = gl.createShader(kind);
    gl.shaderSource(shader, text); gl.compileShader(shader);
    if (!gl.getShaderParameter(shader, gl.COMPILE_STATUS)) throw new Error(gl.getShaderInfoLog(shader));
    gl.attachShader(program, shader);
  }
  gl.linkProgram(program); gl.useProgram(program);
  const names = ["position", "normal", "colour", "centre", "shift", "turn"];

  function mesh(vertices) {
    const buffer = gl.createBuffer();
    gl.bindBuffer(gl.ARRAY_BUFFER, buffer);
    gl.bufferData(gl.ARRAY_BUFFER, new Float32Array(vertices), gl.STATIC_DRAW);
    return { buffer, count: vertices.length / 18 };
  }
  const of = (block) => [...block.centre, ...block.move];
  const none = [0, 0, 0];
  const faces = [], edges = [], resting = [], moving = [], numbers = [];
  data.blocks.forEach((block, place) => {
    const digits = [1, 256, 65536].map((part) => (Math.floor((place + 1) / part) % 256) / 255);
    block.triangles.forEach((corners, k) => {
      for (const corner of corners) {
        faces.push(...block.vertices[corner], ...block.normals[block.faces[k]], ...block.colour, ...of(block));
        numbers.push(...block.vertices[corner], ...none, ...digits, ...of(block));
      }
    });
    for (const edge of block.edges) for (const corner of edge) edges.push(...block.vertices[corner], ...none, 0.25, 0.24, 0.22, ...of(block));
  });
  for (const joint of data.joints) {
    const into = joint.moves ? moving : resting, block = data.blocks[joint.block];
    joint.at.forEach((start, k) => {
      for (const point of [start, joint.at[(k + 1) % joint.at.length]]) into.push(...point, ...none, ...joint.colour, ...of(block));
    });
  }

  const cross = (a, b) => [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]];
  const mixed = (...terms) => [0, 1, 2].map((k) => terms.reduce((sum, [factor, vector]) => sum + factor * vector[k], 0));
  // a tie is a square bar, each end of which moves with its block
  const ties = [];
  for (const tie of data.ties) {
    const [start, end] = tie.at, along = mixed([1, end], [-1, start]);
    const least = along.map(Math.abs).indexOf(Math.min(...along.map(Math.abs)));
    const wide = (v) => v.map((x) => 0.004 * x / Math.hypot(...v));
    const one = wide(cross(along, [0, 1, 2].map((k) => Number(k === least)))), other = wide(cross(along, one));
    const sides = [[1, 1], [-1, 1], [-1, -1], [1, -1]];
    sides.forEach((side, k) => {
      const [a, b] = [side, sides[(k + 1) % 4]];
      for (const [to, [x, y]] of [[0, a], [0, b], [1, a], [1, a], [0, b], [1, b]]) {
        ties.push(...mixed([1, tie.at[to]], [x, one], [y, other]), ...none, ...tie.colour, ...of(data.blocks[tie.blocks[to]]));
      }
    });
  }
  const meshes = { faces: mesh(faces), edges: mesh(edges), resting: mesh(resting), moving: mesh(moving), ties: mesh(ties), numbers: mesh(numbers) };
  const up = data.up, ahead = data.ahead, beside = cross(up, ahead);
  const views = { aslant: [0.65, 0.42], front: [0, 0.03], side: [Math.PI / 2, 0.03], plan: [0, Math.PI / 2 - 1e-3] };
  let [around, above] = views.aslant, near = 1, printed = false;

  // the picture; or, where `picking` is true, every block in a colour that is its number, for `named`
  function draw(picking) {
    const ratio = Math.max(window.devicePixelRatio || 1, printed ? 3 : 1);
    canvas.width = Math.round(canvas.clientWidth * ratio); canvas.height = Math.round(canvas.clientHeight * ratio);
    gl.viewport(0, 0, canvas.width, canvas.height);
    const ground = picking === true ? 0 : 1;
    gl.clearColor(ground, ground, ground, 1); gl.enable(gl.DEPTH_TEST); gl.clear(gl.COLOR_BUFFER_BIT | gl.DEPTH_BUFFER_BIT);
    const eye = mixed([Math.cos(above) * Math.cos(around), ahead], [Math.cos(above) * Math.sin(around), beside], [Math.sin(above), up]);
    const right = mixed([-Math.sin(around), ahead], [Math.cos(around), beside]), top = cross(eye, right);
    const high = 1.5 * near, wide = high * canvas.height / canvas.width;
    const [x, y] = canvas.width > canvas.height ? [wide, high] : [high, high * canvas.width / canvas.height];
    const view = new Float32Array(16);
    [0, 1, 2].forEach((k) => { view[4 * k] = right[k] * x; view[4 * k + 1] = top[k] * y; view[4 * k + 2] = -eye[k] * 0.3; });
    view[15] = 1;
    gl.uniformMatrix4fv(gl.getUniformLocation(program, "view"), false, view);
    gl.uniform3fv(gl.getUniformLocation(program, "lamp"), mixed([0.86, eye], [0.45, top], [0.25, right]));
    gl.uniform1f(gl.getUniformLocation(program, "part"), slider ? slider.value / 1000 : 0);
    let shown = [["faces", gl.TRIANGLES, 0], ["edges", gl.LINES, 4e-4], ["moving", gl.LINES, 2e-3]];
    if (byId("joints").checked) shown.push(["resting", gl.LINES, 1e-3]);
    shown.push(["ties", gl.TRIANGLES, 0.5]);
    if (picking === true) shown = [["numbers", gl.TRIANGLES, 0]];
    for (const [name, kind, towards] of shown) {
      if (!meshes[name].count) continue;
      gl.bindBuffer(gl.ARRAY_BUFFER, meshes[name].buffer);
      names.forEach((attribute, k) => {
        const place = gl.getAttribLocation(program, attribute);
        if (place < 0) return;
        gl.enableVertexAttribArray(place);
        gl.vertexAttribPointer(place, 3, gl.FLOAT, false, 72, 12 * k);
      });
      gl.uniform1f(gl.getUniformLocation(program, "towards"), towards);
      gl.drawArrays(kind, 0, meshes[name].count);
    }
  }

  // the id of the block under the pointer: the pixels around it are of one number, or it is on an edge
  function named(event) {
    draw(true);
    const ratio = canvas.width / canvas.clientWidth, seen = new Uint8Array(36);
    const [x, y] = [Math.floor(event.offsetX * ratio), canvas.height - 1 - Math.floor(event.offsetY * ratio)];
    gl.readPixels(x - 1, y - 1, 3, 3, gl.RGBA, gl.UNSIGNED_BYTE, seen);
    draw();
    const places = [...Array(9).keys()].map((k) => seen[4 * k] + 256 * seen[4 * k + 1] + 65536 * seen[4 * k + 2]);
    const block = places.every((place) => place === places[0]) && data.blocks[places[0] - 1];
    const label = byId("named");
    label.textContent = block ? `${label.dataset.block} ${block.id}` : "";
  }

  let held = null, asked = false;
  canvas.addEventListener("pointerdown", (event) => { held = [event.clientX, event.clientY]; canvas.setPointerCapture(event.pointerId); });
  canvas.addEventListener("pointerup", () => { held = null; });
  canvas.addEventListener("pointermove", (event) => {
    if (!held) {
      if (!asked) requestAnimationFrame(() => { asked = false; named(event); });
      asked = true;
      return;
    }
    around -= (event.clientX - held[0]) * 0.008;
    above = Math.max(-1.57, Math.min(1.57, above + (event.clientY - held[1]) * 0.008));
    held = [event.clientX, event.clientY];
    draw();
  });
  canvas.addEventListener("pointerleave", () => { byId("named").textContent = ""; });
  canvas.addEventListener("wheel", (event) => { event.preventDefault(); near *= Math.exp(-event.deltaY * 0.001); draw(); }, { passive: false });
  for (const button of document.querySelectorAll("button[data-view]")) {
    button.addEventListener("click", () => { [around, above] = views[button.dataset.view]; near = 1; draw(); });
  }
  byId("joints").addEventListener("change", draw);
  window.addEventListener("resize", draw);
  window.addEventListener("beforeprint", () => { printed = true; draw(); });
  window.addEventListener("afterprint", () => { printed = false; draw(); });
  if (slider) {
    slider.addEventListener("input", draw);
    let timer = null;
    play.addEventListener("click", () => {
      if (timer) { clearInterval(timer); timer = null; play.textContent = play.dataset.play; return; }
      if (slider.value >= 1000) slider.value = 0;
      play.textContent = play.dataset.stop;
      timer = setInterval(() => {
        slider.value = Number(slider.value) + 8;
        if (slider.value >= 1000) { clearInterval(timer); timer = null; play.textContent = play.dataset.play; }
        draw();
      }, 30);
    });
  }
  draw();
})();
