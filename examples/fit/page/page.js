'use strict';
// Draws the mesh and its cover with a depth buffer of its own: no library, no graphics card.
const data = JSON.parse(document.getElementById('data').textContent);
const canvas = document.getElementById('view'), context = canvas.getContext('2d');
const state = { yaw: -0.7, pitch: 0.45, zoom: 1, show: 'both' };

function unpack(part) {  // 16-bit integers to metres about the middle of the box
  const out = new Float32Array(part.points.length);
  for (let i = 0; i < out.length; ++i) out[i] = (part.points[i] / 65535 - 0.5) * data.span[i % 3];
  return { points: out, triangles: part.triangles, values: part.values };
}
const mesh = unpack(data.mesh), cover = unpack(data.cover);
const worst = data.worst.map(w => ({ ...w, at: w.at.map((x, i) => x - data.middle[i]) }));
const radius = 0.5 * Math.hypot(...data.span);

// Cividis-like: from dark blue over grey to yellow, distinct for the colour-blind and in grey.
const stops = [[0, 34, 78], [60, 77, 110], [124, 123, 120], [188, 175, 111], [254, 232, 56]];
function ramp(share) {
  const x = Math.min(Math.max(share, 0), 1) * (stops.length - 1), i = Math.min(Math.floor(x), stops.length - 2);
  return stops[i].map((c, k) => c + (x - i) * (stops[i + 1][k] - c));
}
document.getElementById('ramp').style.background =
  'linear-gradient(90deg,' + stops.map(c => `rgb(${c})`).join(',') + ')';

function project(points, R, scale, w, h) {
  const out = new Float32Array(points.length);
  for (let i = 0; i < points.length; i += 3) {
    const x = points[i], y = points[i + 1], z = points[i + 2];
    out[i] = w / 2 + scale * (R[0] * x + R[1] * y + R[2] * z);
    out[i + 1] = h / 2 - scale * (R[3] * x + R[4] * y + R[5] * z);
    out[i + 2] = scale * (R[6] * x + R[7] * y + R[8] * z);  // towards the eye
  }
  return out;
}

// Over others: in every second pixel, and nearer by half a pixel, as faces of the cover lie on those of the mesh.
function fill(frame, p, part, colour, isOver) {
  const { pixels, depth, w, h } = frame, t = part.triangles;
  for (let n = 0; n < t.length; n += 3) {
    // Two edges of the triangle and its area on the screen; triangles seen edge-on are left out.
    const a = 3 * t[n], b = 3 * t[n + 1], c = 3 * t[n + 2];
    const ux = p[b] - p[a], uy = p[b + 1] - p[a + 1], uz = p[b + 2] - p[a + 2];
    const vx = p[c] - p[a], vy = p[c + 1] - p[a + 1], vz = p[c + 2] - p[a + 2];
    const area = ux * vy - uy * vx;
    if (area === 0) continue;
    // Its colour depends on how it is turned to the light.
    const nx = uy * vz - uz * vy, ny = uz * vx - ux * vz, length = Math.hypot(nx, ny, area) || 1;
    const light = 0.45 + 0.55 * Math.abs(0.25 * nx - 0.45 * ny + 0.86 * area) / length;
    const [r, g, l] = colour(n / 3);
    const rgb = (255 << 24) | (Math.min(l * light, 255) << 16) | (Math.min(g * light, 255) << 8) | Math.min(r * light, 255);
    // Pixels inside it are set where nothing nearer was drawn.
    const x0 = Math.max(0, Math.ceil(Math.min(p[a], p[b], p[c]))), x1 = Math.min(w - 1, Math.floor(Math.max(p[a], p[b], p[c])));
    const y0 = Math.max(0, Math.ceil(Math.min(p[a + 1], p[b + 1], p[c + 1]))), y1 = Math.min(h - 1, Math.floor(Math.max(p[a + 1], p[b + 1], p[c + 1])));
    for (let y = y0; y <= y1; ++y) for (let x = x0; x <= x1; ++x) {
      if (isOver && ((x + y) & 1)) continue;
      const dx = x - p[a], dy = y - p[a + 1];
      const s = (dx * vy - dy * vx) / area, q = (ux * dy - uy * dx) / area;
      if (s < 0 || q < 0 || s + q > 1) continue;
      const z = p[a + 2] + s * uz + q * vz + (isOver ? 0.5 : 0), at = y * w + x;
      if (z <= depth[at]) continue;
      depth[at] = z;
      pixels[at] = rgb;
    }
  }
}

function draw() {
  const w = canvas.width = Math.max(280, Math.round(canvas.clientWidth)), h = canvas.height = Math.round(Math.min(w * 0.72, 640));
  const cy = Math.cos(state.yaw), sy = Math.sin(state.yaw), cp = Math.cos(state.pitch), sp = Math.sin(state.pitch);
  const R = [cy, -sy, 0, sp * sy, sp * cy, cp, -cp * sy, -cp * cy, sp];  // z of the part is up
  const scale = 0.6 * Math.min(w, h) / radius * state.zoom;
  const image = context.createImageData(w, h);
  const frame = { pixels: new Uint32Array(image.data.buffer), depth: new Float32Array(w * h).fill(-1e30), w, h };
  if (state.show !== 'cover') fill(frame, project(mesh.points, R, scale, w, h), mesh, () => [150, 165, 180], false);
  if (state.show !== 'mesh')
    fill(frame, project(cover.points, R, scale, w, h), cover, n => ramp(cover.values[n] / 255), state.show === 'both');
  context.putImageData(image, 0, 0);
  const style = getComputedStyle(document.documentElement);
  const ink = style.getPropertyValue('--ink'), bad = style.getPropertyValue('--bad');
  context.font = '600 13px system-ui, sans-serif';
  worst.forEach((place, i) => {
    const p = project(new Float32Array(place.at), R, scale, w, h);
    context.strokeStyle = bad; context.lineWidth = 2;
    context.beginPath(); context.arc(p[0], p[1], 6, 0, 7); context.stroke();
    context.fillStyle = ink; context.fillText(String(i + 1), p[0] + 9, p[1] - 6);
  });
}

function turn(yaw, pitch, zoom) {
  state.yaw += yaw;
  state.pitch = Math.min(Math.max(state.pitch + pitch, -1.57), 1.57);
  state.zoom = Math.min(Math.max(state.zoom * zoom, 0.3), 20);
  draw();
}
const turns = { left: [-0.25, 0, 1], right: [0.25, 0, 1], up: [0, 0.25, 1], down: [0, -0.25, 1], closer: [0, 0, 1.25], farther: [0, 0, 0.8] };
document.querySelectorAll('[data-turn]').forEach(b => b.addEventListener('click', () => turn(...turns[b.dataset.turn])));
document.querySelectorAll('[name=show]').forEach(b => b.addEventListener('change', () => { state.show = b.value; draw(); }));
let last = null;
canvas.addEventListener('pointerdown', e => { last = e; canvas.setPointerCapture(e.pointerId); });
canvas.addEventListener('pointermove', e => {
  if (!last) return;
  turn((e.clientX - last.clientX) * 0.01, (e.clientY - last.clientY) * 0.01, 1);
  last = e;
});
for (const end of ['pointerup', 'pointercancel']) canvas.addEventListener(end, () => { last = null; });
canvas.addEventListener('keydown', e => {
  const by = { ArrowLeft: 'left', ArrowRight: 'right', ArrowUp: 'up', ArrowDown: 'down', '+': 'closer', '-': 'farther' }[e.key];
  if (by) { e.preventDefault(); turn(...turns[by]); }
});
addEventListener('resize', draw);
matchMedia('(prefers-color-scheme: dark)').addEventListener('change', draw);
draw();
