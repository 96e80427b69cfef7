// Meshes of a scene: fetched apart from it, as they are large, and shown instead of the hexahedra that cover them.

import {get} from './panels.js';
import {parts, station, live, redraw, troubleBriefly} from './state.js';

const tries = 30;

// Of what `/meshes/...` serves: [{object, corners}]. @throws Error where the bytes are no such thing.
export function readMeshes(buffer) {
  const view = new DataView(buffer), out = [];
  if (view.byteLength < 8 || view.getUint32(0, true) !== 0x314d5354) throw new Error('no meshes');
  let at = 8;
  for (let left = view.getUint32(4, true); left > 0; --left) {
    const object = view.getUint32(at, true), numbers = 9 * view.getUint32(at + 4, true);
    out.push({object, corners: new Float32Array(buffer, at + 8, numbers)});
    at += 8 + 4 * numbers;
  }
  return out;
}

// Those of the live scene, once they came; a flight that was opened is shown by its hexahedra.
export function showMeshes() {
  const {scene, list} = live.meshes, meshes = station.scene && station.scene === scene ? list : [];
  parts.renderer.setMeshes(meshes);
  get('meshes').hidden = !meshes.length;
  redraw();
}

// The station sends few large answers at a time.
async function ask(path) {
  const token = new URLSearchParams(location.search).get('token');
  for (let left = tries; ; --left) {
    const answer = await fetch(`/${path}${token ? `?token=${encodeURIComponent(token)}` : ''}`);
    if (answer.ok) return answer.arrayBuffer();
    if (answer.status !== 503 || !left) throw new Error(`status ${answer.status}`);
    await new Promise(resolve => { setTimeout(resolve, 200 + 600 * Math.random()); });
  }
}

export async function fetchMeshes(scene) {
  if (!scene.meshes) return;
  try {
    const list = readMeshes(await ask(scene.meshes.path));
    if (live.scene !== scene) return;
    live.meshes = {scene, list};
    showMeshes();
  } catch (fault) {
    if (live.scene === scene) troubleBriefly(`Meshes did not come (${fault.message}): their hexahedra are shown.`);
  }
}
