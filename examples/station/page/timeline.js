// Looks back: keeps the frames that were shown (latest 64 MiB), saves them to a file and opens such files again.
// A file: "TSR1", bytes of the texts, hello and scene as JSON, then each frame with its size before it (u32, little-endian).

import {readFrame} from './frames.js';

const limit = 64 * 1024 * 1024;

// ---- what the page relies on in a file's texts and frames; the first thing that is amiss is thrown

function need(holds, what) {
  if (!holds) throw new Error(what);
}

const isText = value => typeof value === 'string';
const isIndex = (value, count, least = 0) => Number.isInteger(value) && value >= least && value < count;
const areNumbers = (value, count) => Array.isArray(value) && value.length === count && value.every(Number.isFinite);

function checkHello(hello) {
  need(Array.isArray(hello?.methods) && hello.methods.length > 0, 'the saved flight names no methods');
  need(hello.methods.every(method => isText(method?.name)), 'a method of the saved flight has no name');
}

function checkScene(scene) {
  need(isText(scene?.name), 'the saved flight has no scene');
  for (const list of ['objects', 'solids', 'arms', 'cameras']) need(Array.isArray(scene[list]), `the saved flight's scene has no ${list}`);
  const {objects, solids, arms, cameras} = scene;
  const all = (list, name, holds) => list.forEach((one, i) => need(one && holds(one), `${name} ${i} of the saved flight's scene is wrong`));
  all(objects, 'object', one => isText(one.name) && isText(one.kind) && Array.isArray(one.solids) && one.solids.every(solid => isIndex(solid, solids.length)));
  all(solids, 'solid', one => isIndex(one.object, objects.length) && areNumbers(one.vertices, 24));
  all(arms, 'arm', one => Array.isArray(one.joints) && one.joints.every(joint => isText(joint?.name)) && isIndex(one.tip?.object, objects.length) &&
    areNumbers(one.tip.position, 3) && areNumbers(one.base?.rotation, 4));
  all(scene.tips || [], 'tip', one => isIndex(one.object, objects.length) && areNumbers(one.position, 3));
  all(cameras, 'camera', one => isText(one.name) && isIndex(one.object, objects.length, -1) && areNumbers(one.position, 3) && areNumbers(one.look, 3) &&
    (one.up === undefined || areNumbers(one.up, 3)) && Number.isFinite(one.fov));
}

function checkFrames(frames, scene) {
  need(frames.length > 0, 'the saved flight has no frames');
  frames.forEach((buffer, i) => {
    const frame = readFrame(buffer);
    need(frame, `frame ${i} of the saved flight cannot be read`);
    need(frame.objects === scene.objects.length && frame.methods.length > 0, `frame ${i} of the saved flight is not of its scene`);
  });
}

function readTexts(bytes) {
  try {
    return JSON.parse(new TextDecoder().decode(bytes));
  } catch {
    throw new Error('the saved flight\'s texts are no JSON');
  }
}

export class Timeline {
  constructor() {
    Object.assign(this, {frames: [], bytes: 0});
  }

  add(buffer) {
    this.frames.push(buffer);
    this.bytes += buffer.byteLength;
    while (this.bytes > limit) this.bytes -= this.frames.shift().byteLength;
  }

  file(hello, scene) {
    const text = new TextEncoder().encode(JSON.stringify({hello, scene}));
    const parts = [new TextEncoder().encode('TSR1'), new Uint32Array([text.length]), text];
    for (const frame of this.frames) parts.push(new Uint32Array([frame.byteLength]), frame);
    return new Blob(parts, {type: 'application/octet-stream'});
  }

  // @return {hello, scene} of the file. @throws Error, with nothing changed, where it is none that the page can show.
  open(buffer) {
    const view = new DataView(buffer), size = buffer.byteLength;
    need(size >= 8 && view.getUint32(0, false) === 0x54535231, 'this is no saved flight');
    const texts = view.getUint32(4, true);
    need(8 + texts <= size, 'the saved flight is cut off');
    const described = readTexts(new Uint8Array(buffer, 8, texts));
    checkHello(described?.hello);
    checkScene(described.scene);
    const frames = [];
    for (let at = 8 + texts; at + 4 <= size;) {
      const bytes = view.getUint32(at, true);
      if (at + 4 + bytes > size) break;  // what was cut off is left out
      frames.push(buffer.slice(at + 4, at + 4 + bytes));
      at += 4 + bytes;
    }
    checkFrames(frames, described.scene);
    Object.assign(this, {frames, bytes: size});
    return described;
  }
}
