#!/usr/bin/env node
// Rapier (parry, single precision) as an engine: npm install @dimforge/rapier3d-compat
import { OVERLAP, OVERLAPPING, SEPARATED, halfSides, load, quaternion, serve } from './protocol.mjs';

const { module, version } = await load('@dimforge/rapier3d-compat');
const rapier = module.default;
console.log = console.error; // stdout is the answers'
await rapier.init();
let shapes = [];

const vector = ([x, y, z]) => ({ x, y, z });
const list = ({ x, y, z }) => [x, y, z];
const rotation = (R) => { const [x, y, z, w] = quaternion(R); return { x, y, z, w }; };

serve({ name: 'rapier', description: `Rapier ${version} (npm): contactShape, intersectsShape`, distance: true, penetration: true,
  scalar_bits: 32, relative_resolution: 1e-5, depth_resolution: null },
(solids) => {
  shapes = solids.map((corners) => {
    const h = halfSides(corners);
    return h ? new rapier.Cuboid(...h) : new rapier.ConvexPolyhedron(new Float32Array(corners), null);
  });
},
(question, a, b, X_WA, X_WB) => {
  const placed = [vector(X_WA.p), rotation(X_WA.R), shapes[b], vector(X_WB.p), rotation(X_WB.R)];
  if (question.query === OVERLAP) return { status: shapes[a].intersectsShape(...placed) ? OVERLAPPING : SEPARATED };
  const contact = shapes[a].contactShape(...placed, Math.min(question.maxSeparation, 1e30));
  if (!contact) return { status: SEPARATED };
  const status = contact.distance > 0 ? SEPARATED : OVERLAPPING;
  return { status, separation: contact.distance, n: list(contact.normal1), pA: list(contact.point1), pB: list(contact.point2) };
});
