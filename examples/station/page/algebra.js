// Small vectors, unit quaternions [x, y, z, w] and 4x4 matrices (column-major, as WebGL reads them). Metres, radians.

export const add = (a, b) => [a[0] + b[0], a[1] + b[1], a[2] + b[2]];
export const subtract = (a, b) => [a[0] - b[0], a[1] - b[1], a[2] - b[2]];
export const scale = (a, s) => [a[0] * s, a[1] * s, a[2] * s];
export const dot = (a, b) => a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
export const cross = (a, b) =>
  [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]];
export const length = a => Math.hypot(a[0], a[1], a[2]);
export const unit = a => {
  const size = length(a);
  return size > 0 ? scale(a, 1 / size) : [0, 0, 0];
};

// p turned by the quaternion q.
export function turn(q, p) {
  const t = scale(cross(q, p), 2);
  return add(add(p, scale(t, q[3])), cross(q, t));
}

export const conjugate = q => [-q[0], -q[1], -q[2], q[3]];

// The turn by b, then by a.
export function multiply(a, b) {
  return [...add(add(scale(b, a[3]), scale(a, b[3])), cross(a, b)), a[3] * b[3] - dot(a, b)];
}

export function about(axis, angle) {
  return [...scale(unit(axis), Math.sin(angle / 2)), Math.cos(angle / 2)];
}

// The quaternion of a rotation whose columns are x, y and z.
export function fromAxes(x, y, z) {
  const trace = x[0] + y[1] + z[2];
  if (trace > 0) {
    const s = 2 * Math.sqrt(trace + 1);
    return [(y[2] - z[1]) / s, (z[0] - x[2]) / s, (x[1] - y[0]) / s, s / 4];
  }
  if (x[0] > y[1] && x[0] > z[2]) {
    const s = 2 * Math.sqrt(1 + x[0] - y[1] - z[2]);
    return [s / 4, (y[0] + x[1]) / s, (z[0] + x[2]) / s, (y[2] - z[1]) / s];
  }
  if (y[1] > z[2]) {
    const s = 2 * Math.sqrt(1 + y[1] - x[0] - z[2]);
    return [(y[0] + x[1]) / s, s / 4, (z[1] + y[2]) / s, (z[0] - x[2]) / s];
  }
  const s = 2 * Math.sqrt(1 + z[2] - x[0] - y[1]);
  return [(z[0] + x[2]) / s, (z[1] + y[2]) / s, s / 4, (x[1] - y[0]) / s];
}

// A camera at `eye` that looks along its -z axis at `target`, `up` upwards in its picture: the quaternion of its frame.
export function lookAt(eye, target, up = [0, 0, 1]) {
  const back = unit(subtract(eye, target));
  let right = cross(up, back);
  if (length(right) < 1e-6) right = cross([0, 1, 0], back);
  right = unit(right);
  return fromAxes(right, cross(back, right), back);
}

// World to camera: the inverse of the camera's pose.
export function viewMatrix({position, rotation}) {
  const x = turn(rotation, [1, 0, 0]), y = turn(rotation, [0, 1, 0]), z = turn(rotation, [0, 0, 1]);
  return new Float32Array([x[0], y[0], z[0], 0, x[1], y[1], z[1], 0, x[2], y[2], z[2], 0,
    -dot(x, position), -dot(y, position), -dot(z, position), 1]);
}

// Vertical field of view [rad].
export function projectionMatrix(fov, aspect, near, far) {
  const f = 1 / Math.tan(fov / 2);
  return new Float32Array([f / aspect, 0, 0, 0, 0, f, 0, 0, 0, 0, (far + near) / (near - far), -1,
    0, 0, 2 * far * near / (near - far), 0]);
}

// Where a ray from p along d meets the triangle a b c: the multiple of d, or Infinity (Moeller and Trumbore, 1997).
export function rayTriangle(p, d, a, b, c) {
  const e1 = subtract(b, a), e2 = subtract(c, a), h = cross(d, e2), det = dot(e1, h);
  if (Math.abs(det) < 1e-12) return Infinity;
  const s = subtract(p, a), u = dot(s, h) / det;
  if (u < 0 || u > 1) return Infinity;
  const q = cross(s, e1), v = dot(d, q) / det;
  if (v < 0 || u + v > 1) return Infinity;
  const t = dot(e2, q) / det;
  return t > 0 ? t : Infinity;
}

// Where p_W lies in a view of this camera: [x, y] from -1 to 1, or null behind it.
export function project(p_W, camera, aspect) {
  const p = turn(conjugate(camera.rotation), subtract(p_W, camera.position));
  if (p[2] > -1e-3) return null;
  const f = 1 / Math.tan(camera.fov / 2);
  return [p[0] * f / aspect / -p[2], p[1] * f / -p[2]];
}
