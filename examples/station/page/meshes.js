// Meshes of a scene: fetched apart from it, as they are large, and shown instead of the hexahedra that cover them.

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

// Those of the scene that is shown, if they are those that came last.
export function showMeshes() {
  const {path, list} = live.meshes, meshes = path && station.scene?.meshes?.path === path ? list : [];
  parts.renderer.setMeshes(meshes);
  get('meshes').hidden = !meshes.length;
  redraw();
}

// The station sends few large answers at a time, each for half a minute at most.
export async function ask(path, isWanted = () => true) {
  const token = new URLSearchParams(location.search).get('token'), until = performance.now() + 120e3;
  for (;;) {
    const answer = await fetch(`/${path}${token ? `?token=${encodeURIComponent(token)}` : ''}`);
    if (answer.status !== 503 || performance.now() > until || !isWanted()) return answer;
    await new Promise(resolve => { setTimeout(resolve, 200 + 600 * Math.random()); });
  }
}

export async function fetchMeshes(scene) {
  if (!scene.meshes) return;
  try {
    // After a new connection the same scene comes again.
    if (live.meshes.path !== scene.meshes.path) {
      const answer = await ask(scene.meshes.path, () => live.scene === scene);
      if (!answer.ok) throw new Error(`status ${answer.status}`);
      const list = readMeshes(await answer.arrayBuffer());
      if (live.scene !== scene) return;
      live.meshes = {path: scene.meshes.path, list};
    }
    showMeshes();
  } catch (fault) {
    if (live.scene === scene) troubleBriefly(`Meshes did not come (${fault.message}): their hexahedra are shown.`);
  }
}
