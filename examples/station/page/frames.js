// Reads the station's binary frames (protocol.md, "Frames"). Poses stay views of the message: nothing is copied.

const magic = 0x31465354;
export const flag = {brakes: 1, vernier: 2, jointMode: 4, dynamics: 8, rateLimited: 16, atLimit: 32, singular: 64,
  replay: 128, blocked: 256, contact: 512};
export const objectFlag = {contact: 1, blocked: 2, carried: 4, off: 8};
export const contactKind = {contact: 0, near: 1, blocked: 2};

const vector = (view, at) => [view.getFloat32(at, true), view.getFloat32(at + 4, true), view.getFloat32(at + 8, true)];

function readMethod(view, at) {
  const flags = view.getUint16(at + 2, true);
  return {index: view.getUint16(at, true), blocked: (flags & 1) !== 0, contact: (flags & 2) !== 0, slid: (flags & 4) !== 0,
    merged: view.getUint32(at + 4, true), depth: view.getFloat64(at + 8, true), worst: view.getFloat64(at + 16, true),
    judgedFrame: Number(view.getBigUint64(at + 24, true)), judged: view.getUint32(at + 32, true),
    framesBlocked: view.getUint32(at + 36, true), stoppedBy: [view.getInt32(at + 40, true), view.getInt32(at + 44, true)],
    decision: view.getFloat64(at + 48, true), deepest: [view.getInt32(at + 56, true), view.getInt32(at + 60, true)]};
}

function readContact(view, at) {
  return {method: view.getUint16(at, true), kind: view.getUint16(at + 2, true), a: view.getUint32(at + 4, true),
    b: view.getUint32(at + 8, true), separation: view.getFloat32(at + 12, true), point: vector(view, at + 16),
    normal: vector(view, at + 28), force: vector(view, at + 40)};
}

function readDistance(view, at) {
  return {a: view.getUint32(at, true), b: view.getUint32(at + 4, true), separation: view.getFloat64(at + 8, true),
    pointOnA: vector(view, at + 16), pointOnB: vector(view, at + 28)};
}

// The frame in `buffer`, or null where it is none that this page can read.
export function readFrame(buffer) {
  const view = new DataView(buffer);
  if (buffer.byteLength < 128 || view.getUint32(0, true) !== magic || view.getUint16(4, true) !== 1) return null;
  let at = view.getUint16(6, true);
  const frame = {
    frame: Number(view.getBigUint64(8, true)), time: view.getFloat64(16, true), inputStamp: view.getFloat64(24, true),
    received: view.getFloat64(32, true), begun: view.getFloat64(40, true), decided: view.getFloat64(48, true),
    sent: view.getFloat64(56, true), inputClient: view.getUint32(64, true), inputNumber: view.getUint32(68, true),
    objects: view.getUint32(72, true), missed: Number(view.getBigUint64(88, true)),
    overwritten: Number(view.getBigUint64(96, true)), flags: view.getUint32(104, true), serial: view.getUint32(112, true), tip: view.getUint32(116, true)};
  const methods = view.getUint16(76, true), joints = view.getUint16(78, true);
  const contacts = view.getUint32(80, true), distances = view.getUint32(84, true), n = frame.objects;
  const size = at + 64 * methods + 32 * n * (methods + 1) + 16 * joints + 64 * contacts + 48 * distances;
  if (at % 8 !== 0 || buffer.byteLength < size) return null;
  const each = (count, stride, read) => Array.from({length: count}, () => read(view, (at += stride) - stride));
  const poses = () => {
    const found = {poses: new Float32Array(buffer, at, 8 * n), flags: new Uint32Array(buffer, at, 8 * n)};
    at += 32 * n;
    return found;
  };
  frame.methods = each(methods, 64, readMethod);
  for (const method of frame.methods) Object.assign(method, poses());
  frame.commanded = poses();
  frame.joints = each(joints, 16, (v, k) => ({actual: v.getFloat32(k, true), commanded: v.getFloat32(k + 4, true),
    rate: v.getFloat32(k + 8, true), torque: v.getFloat32(k + 12, true)}));
  frame.contacts = each(contacts, 64, readContact);
  frame.distances = each(distances, 48, readDistance);
  return frame;
}

// Whether two frames look alike: the same poses, contacts and distances, and the same said of each method.
export function looksLike(a, b) {
  if (!a || a.methods.length !== b.methods.length || a.serial !== b.serial) return false;
  if (a.methods.some((one, i) => ['index', 'depth', 'worst', 'blocked', 'contact'].some(key => one[key] !== b.methods[i][key]))) return false;
  const words = frame => new Uint32Array(frame.commanded.poses.buffer, frame.methods[0].poses.byteOffset);
  const left = words(a), right = words(b);
  return left.length === right.length && left.every((word, i) => word === right[i]);
}

// Object i's position and quaternion from a frame's poses.
export const positionOf = (poses, i) => Array.from(poses.subarray(8 * i, 8 * i + 3));
export const rotationOf = (poses, i) => Array.from(poses.subarray(8 * i + 3, 8 * i + 7));
