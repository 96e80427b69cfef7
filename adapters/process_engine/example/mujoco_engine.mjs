#!/usr/bin/env node
// MuJoCo (WebAssembly) as an engine: npm install @mujoco/mujoco. Overlap: mj_collision; distance: mj_geomDistance.
import { DISTANCE, OVERLAP, OVERLAPPING, SEPARATED, UNSUPPORTED, halfSides, load, quaternion, serve } from './protocol.mjs';

const { module, version } = await load('@mujoco/mujoco');
console.log = console.error; // stdout is the answers'
const mujoco = await module.default();
const FURTHEST = 1e10;
const MOST_MODELS = 2000; // its memory ends at 2 GB
let solids = [], models = new Map();
const fromto = mujoco.DoubleBuffer.FromArray([0, 0, 0, 0, 0, 0]);

function remove({ model, data }) {
  data?.delete(), model?.delete();
}

/** A model of the pair alone; its poses are written into its data. Left alone, its data would take 14 MB. */
function makeModel(a, b) {
  const geoms = [a, b].map((solid, i) => {
    const h = halfSides(solids[solid]);
    return h ? { geom: `<geom name="g${i}" type="box" size="${h.join(' ')}"/>`, mesh: '' }
      : { geom: `<geom name="g${i}" type="mesh" mesh="m${i}"/>`, mesh: `<mesh name="m${i}" inertia="shell" vertex="${solids[solid].join(' ')}"/>` };
  });
  const xml = `<mujoco><size memory="512K"/><compiler boundmass="1" boundinertia="1"/><asset>${geoms.map((g) => g.mesh).join('')}</asset><worldbody>
    ${geoms.map((g) => `<body mocap="true">${g.geom}</body>`).join('')}</worldbody><contact><pair geom1="g0" geom2="g1"/></contact></mujoco>`;
  try {
    const model = mujoco.MjModel.from_xml_string(xml);
    return { model, data: new mujoco.MjData(model) };
  } catch (error) { // it refuses what is below or above its range
    if (/allocate|abort/i.test(error.message)) throw error; // no memory: for a process anew
    console.error(`pair ${a} ${b}: ${error.message}`);
    return {};
  }
}

/** Contacts are in the middle between the surfaces, frames begin with the normal from geom1 to geom2. */
function manifold(data) {
  const points = [];
  for (let i = 0; i < data.ncon; ++i) {
    const contact = data.contact.get(i), sign = contact.geom[0] === 0 ? 1 : -1;
    const n = Array.from(contact.frame).slice(0, 3).map((x) => x * sign), at = (t) => n.map((x, k) => contact.pos[k] + t * contact.dist * x);
    points.push({ separation: contact.dist, n, pA: at(-0.5), pB: at(0.5) });
    contact.delete?.();
  }
  points.sort((x, y) => x.separation - y.separation);
  return { ...points[0], status: OVERLAPPING, points };
}

serve({ name: 'mujoco_js', description: `MuJoCo ${version} (npm): mj_collision, mj_geomDistance`, distance: true, penetration: true, manifold: true },
  (corners) => {
    models.forEach(remove);
    solids = corners, models = new Map();
  },
  (question, a, b, X_WA, X_WB) => {
    const key = `${a} ${b}`;
    if (!models.has(key)) {
      const [first] = models.size < MOST_MODELS ? [] : models.keys();
      if (first) remove(models.get(first)), models.delete(first);
      models.set(key, makeModel(a, b));
    }
    const { model, data } = models.get(key);
    if (!model) return { status: UNSUPPORTED };
    [X_WA, X_WB].forEach((pose, i) => {
      const [x, y, z, w] = quaternion(pose.R);
      data.mocap_pos.set(pose.p, 3 * i), data.mocap_quat.set([w, x, y, z], 4 * i);
    });
    mujoco.mj_kinematics(model, data);
    if (question.query !== DISTANCE) {
      mujoco.mj_collision(model, data);
      if (data.ncon === 0) return { status: SEPARATED };
      return question.query === OVERLAP ? { status: OVERLAPPING } : manifold(data);
    }
    const limit = Math.min(question.maxSeparation, FURTHEST);
    const separation = mujoco.mj_geomDistance(model, data, 0, 1, limit, fromto);
    if (separation >= limit && separation > 0) return { status: SEPARATED };
    const ends = Array.from(fromto.GetView()), pA = ends.slice(0, 3), pB = ends.slice(3);
    const along = pB.map((x, i) => x - pA[i]), length = Math.hypot(...along) * (separation < 0 ? -1 : 1);
    return { status: separation > 0 ? SEPARATED : OVERLAPPING, separation, n: along.map((x) => x / length), pA, pB };
  });
