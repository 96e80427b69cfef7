// Draws convex hexahedra with WebGL2, without any library: flat shaded faces and their edges, a translucent second pass for
// the commanded poses, thick lines and points for contacts. All solids lie in one vertex buffer, eight vertices each; their objects' poses and
// colours lie in a texture, so that a view of any number of moving objects is one call a pass, and a frame uploads poses alone.

import {turn, rayTriangle, subtract, add, conjugate, unit, viewMatrix, projectionMatrix} from './algebra.js';

// As Hexahedron::kFaceVertices and kEdgeVertices: vertex i has bits (x y z), faces counter-clockwise from outside.
const faceVertices = [[0, 1, 3, 2], [4, 6, 7, 5], [0, 4, 5, 1], [2, 3, 7, 6], [0, 2, 6, 4], [1, 5, 7, 3]];
const edgeVertices = [[0, 4], [1, 5], [2, 6], [3, 7], [0, 2], [1, 3], [4, 6], [5, 7], [0, 1], [2, 3], [4, 5], [6, 7]];

const facesOfSolid = 36, edgesOfSolid = 24;  // indices
const texelsOfObject = 3;  // position and quaternion x; y, z, w and what is shown; colour
const nothing = 0, hexahedra = 1, mesh = 2;  // what is shown of an object

const objectShader = `#version 300 es
precision highp float;
precision highp sampler2D;
uniform sampler2D objects;
uniform mat4 view, projection;
uniform float towardsEye, drawn;
in vec3 position;
in float object;
out vec3 inCamera;
flat out vec4 colour;
void main() {
  int row = int(object);
  vec4 a = texelFetch(objects, ivec2(0, row), 0), b = texelFetch(objects, ivec2(1, row), 0);
  vec3 q = vec3(a.w, b.xy);
  colour = texelFetch(objects, ivec2(2, row), 0);
  vec3 t = 2.0 * cross(q, position);
  vec4 c = view * vec4(position + b.z * t + cross(q, t) + a.xyz, 1.0);
  inCamera = c.xyz;
  gl_Position = projection * vec4(c.xyz * (1.0 - towardsEye), 1.0);
  if (b.w != drawn) gl_Position = vec4(2.0, 2.0, 2.0, 1.0);
}`;

// The normal from the derivatives: a flat face needs none stored, and a bent one gets that of each triangle.
const faceShader = `#version 300 es
precision highp float;
uniform float alpha;
uniform vec3 sun, sky;
in vec3 inCamera;
flat in vec4 colour;
out vec4 shown;
void main() {
  vec3 n = normalize(cross(dFdx(inCamera), dFdy(inCamera)));
  float light = 0.42 + 0.42 * max(dot(n, sun), 0.0) + 0.16 * (0.5 + 0.5 * dot(n, sky));
  shown = vec4(colour.rgb * light, colour.a * alpha);
}`;

const edgeShader = `#version 300 es
precision highp float;
uniform float alpha;
in vec3 inCamera;
flat in vec4 colour;
out vec4 shown;
void main() { shown = vec4(colour.rgb * 0.45, alpha); }`;

// A mark is a quad: along a line between two points, or around a point where both are one. Sizes in pixels, half of them; of at least
// `least`, since what is thinner than the canvas's own pixels falls between them.
const markShader = `#version 300 es
precision highp float;
uniform mat4 view, projection;
uniform vec2 pixels;
uniform float least;
in vec3 from;
in vec3 to;
in vec2 corner;
in float width;
in vec4 tint;
out vec4 colour;
out vec3 at;
void main() {
  vec4 a = projection * view * vec4(from, 1.0), b = projection * view * vec4(to, 1.0);
  float near = 0.001;
  if (a.w < near && b.w < near) { gl_Position = vec4(2.0, 2.0, 2.0, 1.0); return; }
  if (a.w < near) a = mix(b, a, (b.w - near) / (b.w - a.w));
  if (b.w < near) b = mix(a, b, (a.w - near) / (a.w - b.w));
  vec2 way = (b.xy / b.w - a.xy / a.w) * pixels;
  bool point = from == to;
  vec2 along = point || length(way) < 1e-4 ? vec2(1.0, 0.0) : normalize(way);
  vec2 across = vec2(-along.y, along.x);
  vec4 c = corner.x < 0.0 ? a : b;
  vec2 offset = (across * corner.y + (point ? along * corner.x : vec2(0.0))) * max(width, least) / pixels;
  gl_Position = c + vec4(offset * c.w, 0.0, 0.0);
  colour = tint;
  at = vec3(corner, point ? 1.0 : 0.0);
}`;

const markColour = `#version 300 es
precision highp float;
in vec4 colour;
in vec3 at;
out vec4 shown;
void main() {
  if (at.z > 0.5 && dot(at.xy, at.xy) > 1.0) discard;
  shown = at.z > 0.5 && dot(at.xy, at.xy) > 0.55 ? vec4(0.0, 0.0, 0.0, colour.a) : colour;
}`;

// Where the light comes from, in the world.
const sunFrom = unit([0.35, -0.5, 0.8]), skyFrom = [0, 0, 1];

function build(gl, vertex, fragment) {
  const program = gl.createProgram();
  for (const [type, source] of [[gl.VERTEX_SHADER, vertex], [gl.FRAGMENT_SHADER, fragment]]) {
    const shader = gl.createShader(type);
    gl.shaderSource(shader, source);
    gl.compileShader(shader);
    gl.attachShader(program, shader);
  }
  gl.linkProgram(program);
  if (!gl.getProgramParameter(program, gl.LINK_STATUS)) throw new Error(gl.getProgramInfoLog(program) || 'no shader');
  const uniforms = {};
  for (let i = 0; i < gl.getProgramParameter(program, gl.ACTIVE_UNIFORMS); ++i) {
    const name = gl.getActiveUniform(program, i).name;
    uniforms[name] = gl.getUniformLocation(program, name);
  }
  return {program, uniforms};
}

// Binds `attributes` [name, floats] that lie one behind the other in `buffer`, and the indices that go with them.
function layOut(gl, {program}, buffer, attributes, indices = null) {
  const array = gl.createVertexArray();
  gl.bindVertexArray(array);
  gl.bindBuffer(gl.ELEMENT_ARRAY_BUFFER, indices);
  gl.bindBuffer(gl.ARRAY_BUFFER, buffer);
  const stride = 4 * attributes.reduce((sum, [, floats]) => sum + floats, 0);
  let offset = 0;
  for (const [name, floats] of attributes) {
    const place = gl.getAttribLocation(program, name);
    if (place >= 0) {
      gl.enableVertexAttribArray(place);
      gl.vertexAttribPointer(place, floats, gl.FLOAT, false, stride, offset);
    }
    offset += 4 * floats;
  }
  gl.bindVertexArray(null);  // so that no later buffer of indices is taken for its own
  return array;
}

// Parts one behind the other that belong to objects which are shown: [first, count] each. `ends`: by object, the part after its last.
// Where they would be many calls, all parts are one: what is not shown is thrown out vertex by vertex.
export function runsOf(ends, shown, most = 16) {
  const all = [[0, ends.at(-1) ?? 0]];
  if (!shown) return all;
  const runs = [];
  ends.forEach((end, i) => {
    const first = i ? ends[i - 1] : 0, last = runs.at(-1);
    if (!shown[i] || end === first) return;
    if (last && last[0] + last[1] === first) last[1] += end - first;
    else runs.push([first, end - first]);
  });
  return runs.length > most ? all : runs;
}

// Whether no graphics card draws. A browser says so when it is asked for no slow context, but Chromium 156 does not of SwiftShader;
// its drivers' name does.
function drawsBySoftware() {
  const gl = document.createElement('canvas').getContext('webgl2', {failIfMajorPerformanceCaveat: true});
  if (!gl) return true;
  let name = gl.getParameter(gl.RENDERER);
  const names = name === 'WebKit WebGL' && gl.getExtension('WEBGL_debug_renderer_info');
  if (names) name = gl.getParameter(names.UNMASKED_RENDERER_WEBGL);
  gl.getExtension('WEBGL_lose_context')?.loseContext();
  return /swiftshader|llvmpipe|softpipe|software|basic render/i.test(name);
}

export class Renderer {
  // @throws Error where the browser has no WebGL2.
  constructor(canvas) {
    this.canvas = canvas;
    // Where drawing is by software, smoothing takes longer than all else.
    this.software = drawsBySoftware();
    // Kept from picture to picture: not every screen is drawn in each.
    this.gl = canvas.getContext('webgl2', {antialias: !this.software, alpha: false, preserveDrawingBuffer: true, powerPreference: 'high-performance'});
    if (!this.gl) throw new Error('this browser has no WebGL2');
    this.objects = [];
    this.meshes = [];
    this.prepare();
    canvas.addEventListener('webglcontextlost', event => { event.preventDefault(); this.lost = true; });
    canvas.addEventListener('webglcontextrestored', () => {
      this.lost = false;
      this.blank = true;
      this.prepare();
      const {meshes} = this;
      this.setObjects(this.objects);
      this.setMeshes(meshes);
    });
  }

  prepare() {
    const gl = this.gl;
    this.copy = null;
    this.faces = build(gl, objectShader, faceShader);
    this.edges = build(gl, objectShader, edgeShader);
    this.signs = build(gl, markShader, markColour);
    for (const name of ['vertexBuffer', 'faceBuffer', 'edgeBuffer', 'meshBuffer', 'markBuffer']) this[name] = gl.createBuffer();
    const solid = [['position', 3], ['object', 1]];
    this.faceArray = layOut(gl, this.faces, this.vertexBuffer, solid, this.faceBuffer);
    this.edgeArray = layOut(gl, this.edges, this.vertexBuffer, solid, this.edgeBuffer);
    this.meshArray = layOut(gl, this.faces, this.meshBuffer, solid);
    this.markArray = layOut(gl, this.signs, this.markBuffer,
      [['from', 3], ['to', 3], ['corner', 2], ['width', 1], ['tint', 4]]);
    this.texture = gl.createTexture();
    gl.bindTexture(gl.TEXTURE_2D, this.texture);
    gl.texParameteri(gl.TEXTURE_2D, gl.TEXTURE_MIN_FILTER, gl.NEAREST);
    gl.texParameteri(gl.TEXTURE_2D, gl.TEXTURE_MAG_FILTER, gl.NEAREST);
    gl.enable(gl.DEPTH_TEST);
    gl.enable(gl.SCISSOR_TEST);
    gl.enable(gl.CULL_FACE);
    gl.blendFunc(gl.SRC_ALPHA, gl.ONE_MINUS_SRC_ALPHA);
  }

  // Objects: [{solids: [[24 coordinates in the object's frame], ...]}, ...].
  setObjects(objects) {
    this.objects = objects;
    const vertices = [], faces = [], edges = [];
    objects.forEach((object, index) => object.solids.forEach(solid => {
      const first = vertices.length / 4;
      for (let i = 0; i < 8; ++i) vertices.push(solid[3 * i], solid[3 * i + 1], solid[3 * i + 2], index);
      for (const [a, b, c, d] of faceVertices) for (const vertex of [a, b, c, a, c, d]) faces.push(first + vertex);
      for (const edge of edgeVertices) for (const vertex of edge) edges.push(first + vertex);
    }));
    const gl = this.gl;
    this.faceCount = faces.length;
    let end = 0;
    this.ends = objects.map(object => end += object.solids.length);
    gl.bindVertexArray(null);
    gl.bindBuffer(gl.ARRAY_BUFFER, this.vertexBuffer);
    gl.bufferData(gl.ARRAY_BUFFER, new Float32Array(vertices), gl.STATIC_DRAW);
    for (const [buffer, indices] of [[this.faceBuffer, faces], [this.edgeBuffer, edges]]) {
      gl.bindBuffer(gl.ELEMENT_ARRAY_BUFFER, buffer);
      gl.bufferData(gl.ELEMENT_ARRAY_BUFFER, new Uint32Array(indices), gl.STATIC_DRAW);
    }
    this.table = new Float32Array(4 * texelsOfObject * Math.max(1, objects.length));
    this.setMeshes([]);
  }

  // Meshes shown instead of hexahedra, where asked for: [{object, corners}], corners of triangles in the object's frame.
  setMeshes(meshes) {
    this.meshes = meshes;
    const counts = this.objects.map(() => 0);
    for (const {object, corners} of meshes) counts[object] += corners.length / 3;
    let end = 0;
    this.meshEnds = counts.map(count => end += count);
    const vertices = new Float32Array(4 * end);
    let k = 0;
    for (const {object, corners} of [...meshes].sort((a, b) => a.object - b.object))
      for (let i = 0; i < corners.length; i += 3) {
        for (let axis = 0; axis < 3; ++axis) vertices[k++] = corners[i + axis];
        vertices[k++] = object;
      }
    this.gl.bindVertexArray(null);
    this.gl.bindBuffer(this.gl.ARRAY_BUFFER, this.meshBuffer);
    this.gl.bufferData(this.gl.ARRAY_BUFFER, vertices, this.gl.STATIC_DRAW);
  }

  // Poses: 8 numbers an object, as frames carry them (position, quaternion x y z w, flags). Colours: [r, g, b, a] each. `shown`, optional: which.
  // `meshes`: they are shown of what has one.
  upload(poses, colours, shown, meshes = false) {
    const gl = this.gl, table = this.table;
    const drawn = this.objects.map((_, i) => shown && !shown[i] ? nothing : meshes && this.hasMesh(i) ? mesh : hexahedra);
    this.runs = runsOf(this.ends, drawn.map(what => what === hexahedra));
    this.meshRuns = runsOf(this.meshEnds, drawn.map(what => what === mesh));
    for (let i = 0; i < this.objects.length; ++i) {
      const row = 4 * texelsOfObject * i;
      for (let k = 0; k < 7; ++k) table[row + k] = poses[8 * i + k];
      table[row + 7] = drawn[i];
      table.set(colours[i], row + 8);
    }
    gl.activeTexture(gl.TEXTURE0);
    gl.bindTexture(gl.TEXTURE_2D, this.texture);
    gl.texImage2D(gl.TEXTURE_2D, 0, gl.RGBA32F, texelsOfObject, Math.max(1, this.objects.length), 0, gl.RGBA, gl.FLOAT, table);
  }

  hasMesh(object) {
    return this.meshEnds[object] > (object ? this.meshEnds[object - 1] : 0);
  }

  // Marks: [{from, to, width [px], colour [r, g, b, a]}]; a point where `to` is absent.
  setMarks(marks) {
    const data = new Float32Array(marks.length * 6 * 13);
    let k = 0;
    for (const {from, to = from, width, colour} of marks)
      for (const corner of [[-1, -1], [1, -1], [1, 1], [-1, -1], [1, 1], [-1, 1]])
        for (const part of [from, to, corner, [width], colour]) for (const value of part) data[k++] = value;
    this.markCount = marks.length * 6;
    this.gl.bindBuffer(this.gl.ARRAY_BUFFER, this.markBuffer);
    this.gl.bufferData(this.gl.ARRAY_BUFFER, data, this.gl.DYNAMIC_DRAW);
  }

  // @param size {width, height} of the canvas [CSS px]. `kept`: rectangles whose pictures stay where the canvas gets other pixels alone;
  // all else becomes `background`. @return 'blank': all views are to be drawn; 'kept': all but those; '': nothing has changed.
  resize(size, background = [0, 0, 0], kept = []) {
    const ratio = Math.min(window.devicePixelRatio || 1, 2) * (this.detail || 1);
    const width = Math.max(1, Math.round(size.width * ratio)), height = Math.max(1, Math.round(size.height * ratio));
    const isOther = this.canvas.width !== width || this.canvas.height !== height;
    if (!this.blank && !isOther) {
      this.ratio = ratio;
      return '';
    }
    // A card's canvas is smoothed, and nothing can be copied to it; there all views are soon drawn.
    const keeps = !this.blank && this.software && kept.length > 0, from = keeps ? this.copyOut(kept) : [];
    if (isOther) Object.assign(this.canvas, {width, height});
    this.ratio = ratio;
    this.blank = false;
    this.fill({left: 0, top: 0, ...size}, background);
    if (keeps) this.copyIn(from, kept);
    return keeps ? 'kept' : 'blank';
  }

  // What the canvas shows is copied. @return where these rectangles are in the copy.
  copyOut(rects) {
    const gl = this.gl;
    this.copy ??= {texture: gl.createTexture(), frame: gl.createFramebuffer()};
    gl.activeTexture(gl.TEXTURE0);
    gl.bindTexture(gl.TEXTURE_2D, this.copy.texture);
    gl.copyTexImage2D(gl.TEXTURE_2D, 0, gl.RGB, 0, 0, this.canvas.width, this.canvas.height, 0);
    return rects.map(rect => this.place(rect));
  }

  copyIn(from, rects) {
    const gl = this.gl;
    gl.bindFramebuffer(gl.READ_FRAMEBUFFER, this.copy.frame);
    gl.framebufferTexture2D(gl.READ_FRAMEBUFFER, gl.COLOR_ATTACHMENT0, gl.TEXTURE_2D, this.copy.texture, 0);
    rects.forEach((rect, i) => {
      const [x, y, width, height] = from[i], to = this.place(rect);
      gl.scissor(...to);
      gl.blitFramebuffer(x, y, x + width, y + height, to[0], to[1], to[0] + to[2], to[1] + to[3], gl.COLOR_BUFFER_BIT, gl.LINEAR);
    });
    gl.bindFramebuffer(gl.READ_FRAMEBUFFER, null);
  }

  // Of `rect` {left, top, width, height} [CSS px, from the canvas's upper left corner], in the canvas's own pixels.
  place(rect) {
    const r = this.ratio, left = Math.round(rect.left * r), bottom = Math.round((rect.top + rect.height) * r);
    return [left, this.canvas.height - bottom, Math.round((rect.left + rect.width) * r) - left, bottom - Math.round(rect.top * r)];
  }

  fill(rect, colour) {
    const gl = this.gl;
    gl.scissor(...this.place(rect));
    gl.clearColor(...colour, 1);
    gl.clear(gl.COLOR_BUFFER_BIT);
  }

  // A view on `rect`.
  openView(rect, camera, background) {
    const gl = this.gl;
    this.resumeView(rect, camera);
    gl.clearColor(...background, 1);
    gl.clear(gl.COLOR_BUFFER_BIT | gl.DEPTH_BUFFER_BIT);
  }

  // The same view again, over what it shows.
  resumeView(rect, camera) {
    const gl = this.gl, place = this.place(rect);
    gl.viewport(...place);
    gl.scissor(...place);
    this.view = viewMatrix(camera);
    this.projection = projectionMatrix(camera.fov, place[2] / Math.max(1, place[3]), camera.near || 0.05, camera.far || 400);
    this.light = [sunFrom, skyFrom].map(from => turn(conjugate(camera.rotation), from));
    this.pixels = [rect.width / 2, rect.height / 2];
  }

  // Of what was drawn so far: its end is told by hasFinished(), in a later turn.
  mark() {
    const sync = this.gl.fenceSync(this.gl.SYNC_GPU_COMMANDS_COMPLETE, 0);
    this.gl.flush();
    return sync;
  }

  // A mark is asked until it has; a context that was lost has.
  hasFinished(sync) {
    const gl = this.gl;
    if (!sync || gl.isContextLost()) return true;
    if (gl.getSyncParameter(sync, gl.SYNC_STATUS) !== gl.SIGNALED) return false;
    gl.deleteSync(sync);
    return true;
  }

  // A mark that is asked no more.
  forget(sync) {
    this.gl.deleteSync(sync);
  }

  use(which) {
    const gl = this.gl;
    gl.useProgram(which.program);
    gl.uniformMatrix4fv(which.uniforms.view, false, this.view);
    gl.uniformMatrix4fv(which.uniforms.projection, false, this.projection);
  }

  // The objects as uploaded last; `alpha` below 1: translucent, and nothing hides behind them. `over`: over all that lies before.
  drawObjects({alpha = 1, edges = true, over = false} = {}) {
    const gl = this.gl, ghost = alpha < 1;
    if (!this.faceCount) return;
    gl.activeTexture(gl.TEXTURE0);
    gl.bindTexture(gl.TEXTURE_2D, this.texture);
    if (ghost) gl.enable(gl.BLEND);
    if (over) gl.disable(gl.DEPTH_TEST);
    gl.depthMask(!ghost);
    this.use(this.faces);
    gl.uniform1f(this.faces.uniforms.alpha, alpha);
    gl.uniform1f(this.faces.uniforms.towardsEye, 0);
    gl.uniform3fv(this.faces.uniforms.sun, this.light[0]);
    gl.uniform3fv(this.faces.uniforms.sky, this.light[1]);
    gl.uniform1f(this.faces.uniforms.drawn, hexahedra);
    gl.bindVertexArray(this.faceArray);
    for (const [first, count] of this.runs) gl.drawElements(gl.TRIANGLES, facesOfSolid * count, gl.UNSIGNED_INT, 4 * facesOfSolid * first);
    if (this.meshRuns.length) this.drawMeshes(ghost);
    if (edges) {
      this.use(this.edges);
      gl.uniform1f(this.edges.uniforms.drawn, hexahedra);
      gl.uniform1f(this.edges.uniforms.alpha, ghost ? Math.min(1, alpha + 0.25) : 1);
      gl.uniform1f(this.edges.uniforms.towardsEye, 0.001);
      gl.bindVertexArray(this.edgeArray);
      for (const [first, count] of this.runs) gl.drawElements(gl.LINES, edgesOfSolid * count, gl.UNSIGNED_INT, 4 * edgesOfSolid * first);
    }
    gl.disable(gl.BLEND);
    gl.enable(gl.DEPTH_TEST);
    gl.depthMask(true);
  }

  // With the faces' program and what it was told. Both sides, as files' meshes may be open or inside out; of what is seen through the
  // front alone.
  drawMeshes(ghost) {
    const gl = this.gl;
    if (!ghost) gl.disable(gl.CULL_FACE);
    gl.uniform1f(this.faces.uniforms.drawn, mesh);
    gl.bindVertexArray(this.meshArray);
    for (const [first, count] of this.meshRuns) gl.drawArrays(gl.TRIANGLES, first, count);
    gl.enable(gl.CULL_FACE);
  }

  // Marks lie over all else: contacts are mostly inside what touches.
  drawMarks() {
    if (!this.markCount) return;
    const gl = this.gl;
    gl.disable(gl.DEPTH_TEST);
    gl.disable(gl.CULL_FACE);
    gl.enable(gl.BLEND);
    this.use(this.signs);
    gl.uniform2fv(this.signs.uniforms.pixels, this.pixels);
    gl.uniform1f(this.signs.uniforms.least, 0.75 / this.ratio);
    gl.bindVertexArray(this.markArray);
    gl.drawArrays(gl.TRIANGLES, 0, this.markCount);
    gl.disable(gl.BLEND);
    gl.enable(gl.CULL_FACE);
    gl.enable(gl.DEPTH_TEST);
  }

  // The index of the object that the ray from p_W along d_W meets first, or -1.
  pick(p_W, d_W, poses) {
    let nearest = Infinity, found = -1;
    this.objects.forEach((object, index) => {
      const at = Array.from(poses.subarray(8 * index, 8 * index + 3)), q = Array.from(poses.subarray(8 * index + 3, 8 * index + 7));
      const p = turn(conjugate(q), subtract(p_W, at)), d = turn(conjugate(q), d_W);
      for (const solid of object.solids) {
        const vertex = i => [solid[3 * i], solid[3 * i + 1], solid[3 * i + 2]];
        for (const [a, b, c, e] of faceVertices)
          for (const triangle of [[a, b, c], [a, c, e]]) {
            const t = rayTriangle(p, d, ...triangle.map(vertex));
            if (t < nearest) [nearest, found] = [t, index];
          }
      }
    });
    return {index: found, distance: nearest, point: found < 0 ? null : add(p_W, d_W.map(x => x * nearest))};
  }
}
