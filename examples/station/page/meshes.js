// Meshes that robots' files have: fetched apart from the scene, as they are large, and shown instead of the hexahedra that cover them.

import {get} from './panels.js';
import {parts, station, live, redraw, troubleBriefly} from './state.js';

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

// Those of the live scene, once they came; a flight that is looked back at is shown by its hexahedra.
export function showMeshes() {
  const meshes = station.scene === live.scene && live.scene.parts || [];
  parts.renderer.setMeshes(meshes);
  get('meshes').hidden = !meshes.length;
  redraw();
}

export async function fetchMeshes(scene) {
  if (!scene.meshes) return;
  try {
    const token = new URLSearchParams(location.search).get('token');
    const answer = await fetch(`/${scene.meshes.path}${token ? `?token=${encodeURIComponent(token)}` : ''}`);
    if (!answer.ok) throw new Error(`status ${answer.status}`);
    scene.parts = readMeshes(await answer.arrayBuffer());
    if (station.scene === scene) showMeshes();
  } catch (fault) {
    troubleBriefly(`Meshes did not come (${fault.message}): their hexahedra are shown.`);
  }
}
