// Draws the parts, probes and answers of the page's data with WebGL 2; nothing else is loaded.
"use strict";
(() => {
const $ = (id) => document.getElementById(id);
const data = JSON.parse($("data").textContent);

// ---- colours: [red, green, blue, alpha], each 0 to 1
const FRONT = [0.66, 0.72, 0.79, 1], BACK = [0.86, 0.66, 0.47, 1], UNDER = [0.98, 0.86, 0.45, 1];
const SHARED = [0.13, 0.16, 0.2, 1], SEAM = [0.13, 0.16, 0.2, 0.28], BORDER = [0.78, 0.1, 0.1, 1];
const PROBE = [0.16, 0.5, 0.88, 0.3], PROBE_LINE = [0.08, 0.34, 0.72, 1];
const NORMAL = [0.05, 0.55, 0.25, 1], ON_BREP = [0.85, 0.05, 0.45, 1], ON_PROBE = [0.08, 0.34, 0.72, 1];
const INSIDE = [0.05, 0.55, 0.25, 1], OUTSIDE = [0.85, 0.05, 0.45, 1];
const LEGEND = [
  ["face, from outside", FRONT], ["face, from inside", BACK], ["edge of two faces", SHARED], ["seam", SEAM],
  ["open border, or used too often", BORDER], ["probe", PROBE], ["point on the BREP", ON_BREP, true],
  ["point on the probe", ON_PROBE, true], ["normal", NORMAL],
];

// ---- numbers out of base64
function bytes(text) {
  const raw = atob(text), out = new Uint8Array(raw.length);
  for (let i = 0; i < raw.length; i++) out[i] = raw.charCodeAt(i);
  return out.buffer;
}
const floats = (text) => new Float32Array(bytes(text));
const words = (text) => new Uint32Array(bytes(text));
const shorts = (text) => new Int16Array(bytes(text));

// ---- vectors and matrices (columns one after the other)
const add = (a, b, s = 1) => [a[0] + s * b[0], a[1] + s * b[1], a[2] + s * b[2]];
const dot = (a, b) => a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
const cross = (a, b) => [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]];
const norm = (a) => Math.hypot(a[0], a[1], a[2]);
const unit = (a) => { const n = norm(a); return n > 0 ? [a[0] / n, a[1] / n, a[2] / n] : [0, 0, 1]; };
const scaled = (a, s) => [a[0] * s, a[1] * s, a[2] * s];
/** Unit shapes placed: x, y, z axes and origin. */
const placed = (x, y, z, o) => [...x, 0, ...y, 0, ...z, 0, ...o, 1];
const IDENTITY = placed([1, 0, 0], [0, 1, 0], [0, 0, 1], [0, 0, 0]);
/** Two unit vectors across a third. */
function across(n) {
  const x = unit(cross(Math.abs(n[2]) < 0.9 ? [0, 0, 1] : [1, 0, 0], n));
  return [x, cross(n, x)];
}

// ---- the device
const canvas = $("view");
const gl = canvas.getContext("webgl2", { antialias: true, alpha: true, premultipliedAlpha: true });
if (!gl) {
  $("trouble").hidden = false;
  $("trouble").textContent = "This browser gives no WebGL 2: the picture cannot be drawn. The answers stand at the side.";
}
function program(vertex, fragment) {
  const p = gl.createProgram();
  for (const [kind, text] of [[gl.VERTEX_SHADER, vertex], [gl.FRAGMENT_SHADER, fragment]]) {
    const shader = gl.createShader(kind);
    gl.shaderSource(shader, "#version 300 es\nprecision highp float;\n" + text);
    gl.compileShader(shader);
    if (!gl.getShaderParameter(shader, gl.COMPILE_STATUS)) throw new Error(gl.getShaderInfoLog(shader));
    gl.attachShader(p, shader);
  }
  gl.linkProgram(p);
  if (!gl.getProgramParameter(p, gl.LINK_STATUS)) throw new Error(gl.getProgramInfoLog(p));
  const found = { p };
  for (let i = 0; i < gl.getProgramParameter(p, gl.ACTIVE_UNIFORMS); i++) {
    const name = gl.getActiveUniform(p, i).name;
    found[name] = gl.getUniformLocation(p, name);
  }
  return found;
}
let meshes, strokes, dots, corners;
if (gl) {
  meshes = program(
    `layout(location=0) in vec3 position; layout(location=1) in vec3 normal;
     uniform mat4 model, view, proj; out vec3 n, e;
     void main() { vec4 p = view * model * vec4(position, 1.0); e = p.xyz; n = mat3(view) * (mat3(model) * normal); gl_Position = proj * p; }`,
    `in vec3 n, e; uniform vec4 front, back; out vec4 color;
     void main() {
       bool outside = gl_FrontFacing; vec3 m = normalize(n); if (!outside) m = -m;
       vec3 eye = normalize(-e), light = normalize(vec3(0.35, 0.5, 0.8));
       vec4 c = outside ? front : back;
       float l = 0.42 + 0.48 * max(dot(m, light), 0.0) + 0.16 * max(dot(m, eye), 0.0);
       float s = 0.16 * pow(max(dot(m, normalize(light + eye)), 0.0), 40.0);
       color = vec4((c.rgb * l + s) * c.a, c.a);
     }`);
  // A segment as wide as asked, in pixels. Moved to the eye by a part of its distance, so that faces do not hide their own edges.
  strokes = program(
    `layout(location=0) in vec2 corner; layout(location=1) in vec3 from; layout(location=2) in vec3 to;
     uniform mat4 view, proj; uniform vec2 pixels; uniform float width, near;
     void main() {
       vec4 a = view * vec4(from, 1.0), b = view * vec4(to, 1.0);
       if (a.z > -near && b.z < -near) a = mix(a, b, (-near - a.z) / (b.z - a.z));
       if (b.z > -near && a.z < -near) b = mix(b, a, (-near - b.z) / (a.z - b.z));
       a.xyz *= 0.9992; b.xyz *= 0.9992;
       vec4 p = proj * a, q = proj * b;
       vec2 way = (q.xy / q.w - p.xy / p.w) * pixels;
       vec2 side = length(way) > 1e-6 ? normalize(vec2(-way.y, way.x)) : vec2(0.0);
       gl_Position = corner.x < 0.5 ? p : q;
       gl_Position.xy += side * corner.y * width / pixels * gl_Position.w;
     }`,
    `uniform vec4 front; out vec4 color; void main() { color = vec4(front.rgb * front.a, front.a); }`);
  dots = program(
    `layout(location=0) in vec3 position; uniform mat4 view, proj; uniform float width;
     void main() { vec4 p = view * vec4(position, 1.0); p.xyz *= 0.999; gl_Position = proj * p; gl_PointSize = width; }`,
    `uniform vec4 front; out vec4 color;
     void main() { float r = length(gl_PointCoord - 0.5); if (r > 0.5) discard; color = vec4((r > 0.36 ? vec3(1.0) : front.rgb) * front.a, front.a); }`);
  corners = buffer(new Float32Array([0, -1, 0, 1, 1, -1, 1, 1]));
}
function buffer(array, target) {
  const b = gl.createBuffer();
  gl.bindBuffer(target || gl.ARRAY_BUFFER, b);
  gl.bufferData(target || gl.ARRAY_BUFFER, array, gl.STATIC_DRAW);
  return b;
}
function meshOf(positions, normals, indices) {
  const vao = gl.createVertexArray();
  gl.bindVertexArray(vao);
  buffer(positions);
  gl.enableVertexAttribArray(0);
  gl.vertexAttribPointer(0, 3, gl.FLOAT, false, 0, 0);
  buffer(normals);
  gl.enableVertexAttribArray(1);
  gl.vertexAttribPointer(1, 3, gl.SHORT, true, 8, 0);
  buffer(indices, gl.ELEMENT_ARRAY_BUFFER);
  gl.bindVertexArray(null);
  return { vao, count: indices.length };
}
/** Segments, six numbers each. */
function segmentsOf(array) {
  const vao = gl.createVertexArray();
  gl.bindVertexArray(vao);
  gl.bindBuffer(gl.ARRAY_BUFFER, corners);
  gl.enableVertexAttribArray(0);
  gl.vertexAttribPointer(0, 2, gl.FLOAT, false, 0, 0);
  const b = buffer(array);
  for (const k of [1, 2]) {
    gl.enableVertexAttribArray(k);
    gl.vertexAttribPointer(k, 3, gl.FLOAT, false, 24, 12 * (k - 1));
    gl.vertexAttribDivisor(k, 1);
  }
  gl.bindVertexArray(null);
  return { vao, b, count: array.length / 6 };
}
function pointsOf(array) {
  const vao = gl.createVertexArray();
  gl.bindVertexArray(vao);
  const b = buffer(array);
  gl.enableVertexAttribArray(0);
  gl.vertexAttribPointer(0, 3, gl.FLOAT, false, 0, 0);
  gl.bindVertexArray(null);
  return { vao, b, count: array.length / 3 };
}
function forget(thing) {
  gl.deleteVertexArray(thing.vao);
  gl.deleteBuffer(thing.b);
}

// ---- parts, brought to the device when first shown
const shapes = {};
for (const [name, s] of Object.entries(data.shapes)) {
  if (gl) shapes[name] = meshOf(floats(s.positions), shorts(s.normals), words(s.indices));
}
const parts = data.parts.map(() => null);
function part(k) {
  if (parts[k]) return parts[k];
  const from = data.parts[k];
  const positions = floats(from.positions), indices = words(from.indices);
  const boxes = from.faces.map(([, , first, count]) => {
    const lo = [Infinity, Infinity, Infinity], hi = [-Infinity, -Infinity, -Infinity];
    for (let i = first; i < first + count; i++) {
      for (let c = 0; c < 3; c++) {
        const x = positions[3 * indices[i] + c];
        lo[c] = Math.min(lo[c], x);
        hi[c] = Math.max(hi[c], x);
      }
    }
    return [lo, hi];
  });
  const kinds = { shared: [], seam: [], border: [] };
  const line = floats(from.line_points);
  for (const [kind, first, count] of from.lines) {
    const to = kinds[kind];
    for (let i = first; i + 1 < first + count; i++) for (let c = 0; c < 6; c++) to.push(line[3 * i + c]);
  }
  const lines = {};
  for (const [kind, list] of Object.entries(kinds)) lines[kind] = segmentsOf(new Float32Array(list));
  return (parts[k] = { ...from, positions, indices, boxes, lines, mesh: meshOf(positions, shorts(from.normals), indices) });
}

// ---- the eye: it looks at `target` from `distance`, turned by `yaw` and `pitch`, z up
const VIEW_ANGLE = 28 * Math.PI / 180;
const FIRST = unit([0.5, -0.7, 0.6]);
function facing(direction) {
  const d = unit(direction);
  return { yaw: Math.atan2(d[1], d[0]), pitch: Math.asin(Math.max(-0.999, Math.min(0.999, d[2]))) };
}
function fitted(radius, aspect, direction) {
  const half = Math.min(VIEW_ANGLE / 2, Math.atan(Math.tan(VIEW_ANGLE / 2) * aspect));
  return { target: [0, 0, 0], distance: 1.08 * radius / Math.sin(half), ...facing(direction) };
}
function axes(eye) {
  const cp = Math.cos(eye.pitch), back = [cp * Math.cos(eye.yaw), cp * Math.sin(eye.yaw), Math.sin(eye.pitch)];
  const right = [-Math.sin(eye.yaw), Math.cos(eye.yaw), 0];
  return [right, cross(back, right), back];
}
function matrices(eye, aspect, radius) {
  const [x, y, z] = axes(eye);
  const at = add(eye.target, z, eye.distance);
  const view = [x[0], y[0], z[0], 0, x[1], y[1], z[1], 0, x[2], y[2], z[2], 0, -dot(x, at), -dot(y, at), -dot(z, at), 1];
  const reach = 2 * radius + norm(eye.target);
  const near = Math.max(eye.distance * 0.01, eye.distance - reach), far = eye.distance + reach;
  const f = 1 / Math.tan(VIEW_ANGLE / 2);
  const proj = [f / aspect, 0, 0, 0, 0, f, 0, 0, 0, 0, (far + near) / (near - far), -1, 0, 0, 2 * far * near / (near - far), 0];
  return { view, proj, near, at };
}
/** How far what is shown of a query reaches from the part's centre. A probe far larger than the part does not count. */
function reach(query) {
  const own = data.parts[query ? query.part : shown.part].radius;
  let most = own;
  const p = query && query.probe;
  if (p && p.ball) most = Math.max(most, norm(p.ball.center) + p.ball.radius);
  if (p && p.plane) most = Math.max(most, norm(p.plane.center) + 1.2 * p.plane.half);
  if (p && p.line) most = Math.max(most, norm(p.line.from), norm(p.line.to));
  return Math.min(most, 2.5 * own);
}
/** A direction from which the part is well seen, and the contact, too. */
function aimed(query) {
  const mark = query && query.marks.find((m) => m.normal);
  if (!mark) return FIRST;
  const inner = query.probe && query.probe.ball && norm(add(mark.at, mark.normal)) < norm(mark.at);
  return inner ? FIRST : add(FIRST, mark.normal, 0.7);
}

// ---- drawing
function mesh(thing, model, front, back, first = 0, count = thing.count) {
  gl.uniformMatrix4fv(meshes.model, false, model);
  gl.uniform4fv(meshes.front, front);
  gl.uniform4fv(meshes.back, back);
  gl.bindVertexArray(thing.vao);
  gl.drawElements(gl.TRIANGLES, count, gl.UNSIGNED_INT, 4 * first);
}
function stroke(thing, color, width) {
  if (!thing.count) return;
  gl.uniform4fv(strokes.front, color);
  gl.uniform1f(strokes.width, width);
  gl.bindVertexArray(thing.vao);
  gl.drawArraysInstanced(gl.TRIANGLE_STRIP, 0, 4, thing.count);
}
function use(one, eye) {
  gl.useProgram(one.p);
  gl.uniformMatrix4fv(one.view, false, eye.view);
  gl.uniformMatrix4fv(one.proj, false, eye.proj);
  if (one.near) gl.uniform1f(one.near, eye.near);
  if (one.pixels) gl.uniform2f(one.pixels, eye.width, eye.height);
}
const faded = (c, s) => [c[0], c[1], c[2], c[3] * s];
const lighter = (c, alpha) => [c[0], c[1], c[2], alpha];

/** Arrows, points and lines of the marks of queries. */
function marks(queries, eye, camera, scale) {
  const length = 0.05 * camera.distance;
  const points = { brep: [], probe: [], inside: [], outside: [] }, arrows = [], stems = [], gaps = [], inFace = [];
  for (const q of queries) {
    for (const m of q.marks) {
      points[m.kind].push(...m.at);
      if (m.to) {
        points.probe.push(...m.to);
        gaps.push(...m.at, ...m.to);
      }
      if (m.until) inFace.push(...m.at, ...m.until);
      for (const n of [m.normal, ...(m.arrows || [])]) {
        if (!n) continue;
        const tip = add(m.at, n, length), [x, y] = across(unit(n));
        stems.push(...m.at, ...add(m.at, n, 0.75 * length));
        arrows.push(placed(scaled(x, 0.1 * length), scaled(y, 0.1 * length), scaled(n, 0.3 * length), add(tip, n, -0.3 * length)));
      }
    }
  }
  const made = [
    [segmentsOf(new Float32Array(gaps)), ON_PROBE, 2], [segmentsOf(new Float32Array(inFace)), ON_BREP, 4],
    [segmentsOf(new Float32Array(stems)), NORMAL, 2.4],
  ];
  const clouds = [
    [pointsOf(new Float32Array(points.probe)), ON_PROBE, 8], [pointsOf(new Float32Array(points.brep)), ON_BREP, 9],
    [pointsOf(new Float32Array(points.inside)), INSIDE, 9], [pointsOf(new Float32Array(points.outside)), OUTSIDE, 9],
  ];
  // What faces hide is drawn faintly through them.
  for (const [func, alpha] of [[gl.GREATER, 0.35], [gl.LEQUAL, 1]]) {
    gl.depthFunc(func);
    gl.depthMask(func === gl.LEQUAL);
    use(strokes, eye);
    for (const [thing, color, width] of made) stroke(thing, faded(color, alpha), width * scale);
    use(meshes, eye);
    for (const model of arrows) mesh(shapes.cone, model, faded(NORMAL, alpha), faded(NORMAL, alpha));
    use(dots, eye);
    for (const [thing, color, width] of clouds) {
      if (!thing.count) continue;
      gl.uniform4fv(dots.front, faded(color, alpha));
      gl.uniform1f(dots.width, width * scale);
      gl.bindVertexArray(thing.vao);
      gl.drawArrays(gl.POINTS, 0, thing.count);
    }
  }
  gl.depthMask(true);
  for (const [thing] of [...made, ...clouds]) forget(thing);
}

function probe(query, eye, camera, scale) {
  const p = query.probe;
  if (!p) return;
  const edge = [];
  const solid = [];
  if (p.ball) {
    const { center, radius: r } = p.ball;
    solid.push([shapes.ball, placed([r, 0, 0], [0, r, 0], [0, 0, r], center)]);
    if (r === 0) {
      const s = 0.01 * camera.distance;
      for (const d of [[s, 0, 0], [0, s, 0], [0, 0, s]]) edge.push(...add(center, d, -1), ...add(center, d));
    }
  } else if (p.plane) {
    const { center, normal, half } = p.plane, [x, y] = across(normal);
    solid.push([shapes.square, placed(scaled(x, half), scaled(y, half), scaled(normal, half), center)]);
    const at = [[-1, -1], [1, -1], [1, 1], [-1, 1]].map(([a, b]) => add(add(center, x, a * half), y, b * half));
    at.forEach((c, i) => edge.push(...c, ...at[(i + 1) % 4]));
    // Short lines from the border into the half-space say on which side it lies.
    const inward = scaled(normal, -0.08 * half);
    for (let i = 0; i < 4; i++) {
      for (let k = 0; k < 6; k++) {
        const c = add(scaled(at[i], 1 - k / 6), at[(i + 1) % 4], k / 6);
        edge.push(...c, ...add(c, inward));
      }
    }
  } else if (p.line) {
    edge.push(...p.line.from, ...p.line.to);
  }
  const lines = segmentsOf(new Float32Array(edge));
  use(strokes, eye);
  for (const [func, alpha] of [[gl.GREATER, 0.3], [gl.LEQUAL, 1]]) {
    gl.depthFunc(func);
    stroke(lines, faded(PROBE_LINE, alpha), (p.line ? 3 : 1.2) * scale);
  }
  if (p.line && p.line.start) {
    const start = pointsOf(new Float32Array(p.line.start));
    use(dots, eye);
    gl.uniform4fv(dots.front, PROBE_LINE);
    gl.uniform1f(dots.width, 7 * scale);
    gl.bindVertexArray(start.vao);
    gl.drawArrays(gl.POINTS, 0, start.count);
    forget(start);
  }
  forget(lines);
  use(meshes, eye);
  gl.depthMask(false);
  gl.enable(gl.CULL_FACE);
  for (const [func, alpha] of [[gl.GREATER, 0.35], [gl.LEQUAL, 1]]) {
    gl.depthFunc(func);
    for (const [shape, model] of solid) {
      for (const side of [gl.FRONT, gl.BACK]) {
        gl.cullFace(side);
        mesh(shape, model, faded(PROBE, alpha), faded(PROBE, alpha));
      }
    }
  }
  gl.disable(gl.CULL_FACE);
  gl.depthMask(true);
}

/** One picture: `k` is the query that is picked, -1 for none. */
function picture(k, partIndex, camera, width, height, scale, what) {
  const one = part(partIndex), query = k >= 0 ? data.queries[k] : null;
  const eye = { ...matrices(camera, width / height, reach(query)), width, height };
  gl.viewport(0, 0, width, height);
  gl.clearColor(0, 0, 0, 0);
  gl.clear(gl.COLOR_BUFFER_BIT | gl.DEPTH_BUFFER_BIT);
  gl.enable(gl.DEPTH_TEST);
  gl.enable(gl.BLEND);
  gl.blendFunc(gl.ONE, gl.ONE_MINUS_SRC_ALPHA);
  gl.depthFunc(gl.LEQUAL);
  const faces = (front, back, highlight) => {
    use(meshes, eye);
    gl.enable(gl.POLYGON_OFFSET_FILL);
    gl.polygonOffset(1, 1);
    const face = what.under >= 0 ? one.faces[what.under] : null;
    const [first, count] = face ? [face[2], face[3]] : [0, 0];
    if (first > 0) mesh(one.mesh, IDENTITY, front, back, 0, first);
    if (count) mesh(one.mesh, IDENTITY, highlight, highlight, first, count);
    mesh(one.mesh, IDENTITY, front, back, first + count, one.mesh.count - first - count);
    gl.disable(gl.POLYGON_OFFSET_FILL);
  };
  const outlines = () => {
    if (!what.edges) return;
    use(strokes, eye);
    stroke(one.lines.seam, SEAM, 1 * scale);
    stroke(one.lines.shared, SHARED, 1.3 * scale);
    stroke(one.lines.border, BORDER, 1.8 * scale);
  };
  if (what.faces && !what.through) faces(FRONT, BACK, UNDER);
  outlines();
  const all = what.all ? data.queries.filter((q) => q.part === partIndex) : query ? [query] : [];
  if (what.marks) marks(all, eye, camera, scale);
  gl.depthFunc(gl.LEQUAL);
  if (what.faces && what.through) {
    gl.depthMask(false);
    gl.enable(gl.CULL_FACE);
    for (const side of [gl.FRONT, gl.BACK]) {
      gl.cullFace(side);
      faces(lighter(FRONT, 0.3), lighter(BACK, 0.3), lighter(UNDER, 0.5));
    }
    gl.disable(gl.CULL_FACE);
    gl.depthMask(true);
  }
  if (query && what.probe) probe(query, eye, camera, scale);
  gl.bindVertexArray(null);
}

// ---- what is shown
const shown = { query: -1, part: 0, under: -1, camera: null, turned: false, waiting: false };
const switches = ["faces", "through", "edges", "probe", "marks", "all"];
const state = () => Object.fromEntries(switches.map((s) => [s, $(s).checked]));
function draw() {
  if (!gl || !data.parts.length || shown.waiting) return;
  shown.waiting = true;
  requestAnimationFrame(now);
}
function now() {
  shown.waiting = false;
  const scale = window.devicePixelRatio || 1;
  const width = Math.max(1, Math.round(canvas.clientWidth * scale)), height = Math.max(1, Math.round(canvas.clientHeight * scale));
  if (canvas.width !== width || canvas.height !== height) [canvas.width, canvas.height] = [width, height];
  if (!shown.camera) aim();
  picture(shown.query, shown.part, shown.camera, width, height, scale, { ...state(), under: shown.under });
}
function aim() {
  const query = shown.query >= 0 ? data.queries[shown.query] : null;
  shown.camera = fitted(reach(query), Math.max(canvas.clientWidth, 1) / Math.max(canvas.clientHeight, 1), aimed(query));
  shown.turned = false;
}
function say(lines) {
  $("about").replaceChildren(...lines.map((text) => Object.assign(document.createElement("p"), { textContent: text })));
}
function about() {
  const p = data.parts[shown.part];
  if (!p) return say(data.notes);
  say([
    `${p.name}: ${p.faces.length} faces, ${p.indices_count / 3} triangles`,
    `chords asked for: within ${p.chord.toPrecision(3)} (${p.chord_relative.toPrecision(2)} of the size); largest found, sampled: ${p.chord_found.toPrecision(3)}`,
    ...p.notes, ...data.notes,
  ]);
}
function pick(k, keep) {
  const query = data.queries[k];
  const other = query && query.part !== shown.part;
  shown.query = query ? k : -1;
  if (query) shown.part = query.part;
  shown.under = -1;
  if (!keep && (other || !shown.turned)) shown.camera = null;
  for (const li of $("queries").children) li.setAttribute("aria-selected", String(Number(li.dataset.k) === shown.query));
  const chosen = $("queries").querySelector("[aria-selected=true]");
  if (chosen) chosen.scrollIntoView({ block: "nearest" });
  $("details").textContent = query ? `${query.judged ? query.judged + "\n\n" : ""}${query.query}\n\n${query.answer}` : "";
  $("overview").hidden = true;
  about();
  draw();
}
for (const s of switches) $(s).addEventListener("change", draw);
$("aim").addEventListener("click", () => { aim(); draw(); });
window.addEventListener("resize", draw);

// ---- the mouse and fingers
const held = new Map();
canvas.addEventListener("contextmenu", (e) => e.preventDefault());
canvas.addEventListener("pointerdown", (e) => {
  canvas.setPointerCapture(e.pointerId);
  held.set(e.pointerId, [e.clientX, e.clientY]);
});
for (const name of ["pointerup", "pointercancel"]) canvas.addEventListener(name, (e) => held.delete(e.pointerId));
canvas.addEventListener("pointermove", (e) => {
  const before = held.get(e.pointerId), c = shown.camera;
  if (!c) return;
  if (!before) return hover(e);
  const step = [e.clientX - before[0], e.clientY - before[1]];
  shown.turned = true;
  const pan = (dx, dy) => {
    const [x, y] = axes(c), s = 2 * c.distance * Math.tan(VIEW_ANGLE / 2) / canvas.clientHeight;
    c.target = add(add(c.target, x, -dx * s), y, dy * s);
  };
  if (held.size === 2) {
    const other = [...held].find(([id]) => id !== e.pointerId)[1];
    const spread = (p) => Math.hypot(p[0] - other[0], p[1] - other[1]);
    c.distance *= spread(before) / Math.max(spread([e.clientX, e.clientY]), 1);
    pan(step[0] / 2, step[1] / 2);
  } else if (e.buttons & 6 || e.shiftKey) {
    pan(...step);
  } else {
    c.yaw -= step[0] * 0.008;
    c.pitch = Math.max(-1.57, Math.min(1.57, c.pitch + step[1] * 0.008));
  }
  held.set(e.pointerId, [e.clientX, e.clientY]);
  draw();
});
canvas.addEventListener("wheel", (e) => {
  e.preventDefault();
  if (!shown.camera) return;
  shown.turned = true;
  const least = 1e-6 * data.parts[shown.part].radius;
  shown.camera.distance = Math.max(least, shown.camera.distance * Math.exp(Math.max(-60, Math.min(60, e.deltaY)) * 0.003));
  draw();
}, { passive: false });
canvas.addEventListener("dblclick", (e) => {
  const hit = under(e);
  if (!hit) return;
  shown.camera.target = hit.point;
  shown.turned = true;
  draw();
});

// ---- the face under the cursor
/** The nearest triangle on a ray, by Moeller and Trumbore's method: O(triangles whose face's box it meets). */
function under(event) {
  if (!gl || !shown.camera) return null;
  const one = part(shown.part), box = canvas.getBoundingClientRect();
  const [x, y, z] = axes(shown.camera), t = Math.tan(VIEW_ANGLE / 2), aspect = box.width / box.height;
  const sx = (2 * (event.clientX - box.left) / box.width - 1) * t * aspect, sy = (1 - 2 * (event.clientY - box.top) / box.height) * t;
  const from = add(shown.camera.target, z, shown.camera.distance), way = unit(add(add(scaled(z, -1), x, sx), y, sy));
  const P = one.positions, I = one.indices;
  let best = Infinity, face = -1;
  one.faces.forEach(([, , first, count], f) => {
    const [lo, hi] = one.boxes[f];
    let a = 0, b = best;
    for (let c = 0; c < 3; c++) {
      if (way[c] === 0) { if (from[c] < lo[c] || from[c] > hi[c]) return; continue; }
      const p = (lo[c] - from[c]) / way[c], q = (hi[c] - from[c]) / way[c];
      a = Math.max(a, Math.min(p, q));
      b = Math.min(b, Math.max(p, q));
    }
    if (a > b + 1e-6 * one.radius) return;
    for (let i = first; i < first + count; i += 3) {
      const i0 = 3 * I[i], i1 = 3 * I[i + 1], i2 = 3 * I[i + 2];
      const ax = P[i1] - P[i0], ay = P[i1 + 1] - P[i0 + 1], az = P[i1 + 2] - P[i0 + 2];
      const bx = P[i2] - P[i0], by = P[i2 + 1] - P[i0 + 1], bz = P[i2 + 2] - P[i0 + 2];
      const hx = way[1] * bz - way[2] * by, hy = way[2] * bx - way[0] * bz, hz = way[0] * by - way[1] * bx;
      const det = ax * hx + ay * hy + az * hz;
      if (det === 0) continue;
      const sx0 = from[0] - P[i0], sy0 = from[1] - P[i0 + 1], sz0 = from[2] - P[i0 + 2];
      const u = (sx0 * hx + sy0 * hy + sz0 * hz) / det;
      if (u < 0 || u > 1) continue;
      const qx = sy0 * az - sz0 * ay, qy = sz0 * ax - sx0 * az, qz = sx0 * ay - sy0 * ax;
      const v = (way[0] * qx + way[1] * qy + way[2] * qz) / det;
      if (v < 0 || u + v > 1) continue;
      const d = (bx * qx + by * qy + bz * qz) / det;
      if (d > 0 && d < best) { best = d; face = f; }
    }
  });
  return face < 0 ? null : { face, point: add(from, way, best) };
}
function hover(event) {
  const hit = under(event), one = data.parts[shown.part];
  const before = shown.under;
  shown.under = hit ? hit.face : -1;
  if (hit) {
    const [number, kind] = one.faces[hit.face];
    const at = hit.point.map((x, c) => (x + one.center[c]).toPrecision(6)).join(", ");
    $("under").textContent = `face ${number}: ${kind}  (${at})`;
  } else {
    $("under").textContent = "";
  }
  if (before !== shown.under) draw();
}
canvas.addEventListener("pointerleave", () => { shown.under = -1; $("under").textContent = ""; draw(); });

// ---- lists
function badge(query) {
  return Object.assign(document.createElement("span"), { className: `state ${query.state}`, textContent: query.state });
}
function list() {
  $("title").textContent = data.title;
  document.title = `${data.title}: feeler view`;
  $("legend").append(...LEGEND.filter((l, i) => i < 5 || data.queries.length).map(([text, color, dot]) => {
    const li = document.createElement("li"), i = document.createElement("i");
    if (dot) i.className = "dot";
    i.style.background = `rgba(${color.slice(0, 3).map((c) => Math.round(255 * c)).join(",")},${Math.max(color[3], 0.45)})`;
    li.append(i, text);
    return li;
  }));
  $("all-label").hidden = data.queries.length < 2;
  $("queries").append(...data.queries.map((q, k) => {
    const li = document.createElement("li");
    li.dataset.k = k;
    li.setAttribute("role", "option");
    li.append(badge(q), `${q.label}: ${q.summary}`);
    li.addEventListener("click", () => pick(k === shown.query ? -1 : k));
    return li;
  }));
}
/** Pictures of the overview are drawn when they come into sight, or nearly so: hundreds at once are more than a browser bears. */
const sight = {
  waiting: new Map(),
  observer: new IntersectionObserver((entries) => {
    for (const { target, isIntersecting } of entries) {
      const drawn = isIntersecting && sight.waiting.get(target);
      if (!drawn) continue;
      drawn();
      sight.waiting.delete(target);
      sight.observer.unobserve(target);
    }
    if ($("overview").hidden) draw();
  }, { root: $("overview"), rootMargin: "50% 0px" }),
};
function overview() {
  const box = $("overview");
  box.hidden = false;
  say(data.notes);
  if (box.children.length || !gl) return;
  const scale = window.devicePixelRatio || 1, width = Math.round(420 * scale), height = Math.round(300 * scale);
  data.queries.forEach((q, k) => {
    const figure = document.createElement("figure"), image = document.createElement("canvas"), caption = document.createElement("figcaption");
    // As large as it will be, but without memory until it comes into sight.
    [image.width, image.height] = [1, 1];
    image.style.aspectRatio = `${width} / ${height}`;
    const name = document.createElement("b");
    name.textContent = q.label;
    caption.append(badge(q), name, q.summary);
    figure.append(image, caption);
    figure.addEventListener("click", () => pick(k));
    box.append(figure);
    sight.waiting.set(figure, () => {
      [image.width, image.height] = [width, height];
      [canvas.width, canvas.height] = [width, height];
      const camera = fitted(reach(q), width / height, aimed(q));
      picture(k, q.part, camera, width, height, scale, { faces: true, edges: true, probe: true, marks: true, under: -1 });
      image.getContext("2d").drawImage(canvas, 0, 0);
    });
    sight.observer.observe(figure);
  });
}
$("whole").addEventListener("click", () => { history.replaceState(null, "", "#overview"); overview(); });

list();
$("whole").hidden = !(gl && data.queries.length > 1);
/** What the address asks for: #N is the N-th query from 1, #overview all of them. */
function follow() {
  const text = location.hash.slice(1);
  if (/^\d+$/.test(text) && data.queries[Number(text) - 1]) pick(Number(text) - 1);
  else if (text === "overview" || (text === "" && data.overview)) { pick(-1, true); overview(); }
  else pick(text === "" && data.queries.length ? 0 : -1);
}
window.addEventListener("hashchange", follow);
follow();
})();
