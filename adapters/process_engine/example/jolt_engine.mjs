#!/usr/bin/env node
// Jolt (single precision) as an engine: npm install jolt-physics. Convex radius 0, so that boxes have corners; else defaults.
import { OVERLAP, OVERLAPPING, SEPARATED, UNSUPPORTED, halfSides, load, quaternion, serve } from './protocol.mjs';

const { module, version } = await load('jolt-physics');
const jolt = await module.default();
const LAYER = 0;

function makeWorld() {
  const settings = new jolt.JoltSettings();
  const pairs = new jolt.ObjectLayerPairFilterTable(1), broad = new jolt.BroadPhaseLayerInterfaceTable(1, 1);
  broad.MapObjectToBroadPhaseLayer(LAYER, new jolt.BroadPhaseLayer(0));
  settings.mObjectLayerPairFilter = pairs, settings.mBroadPhaseLayerInterface = broad;
  settings.mObjectVsBroadPhaseLayerFilter = new jolt.ObjectVsBroadPhaseLayerFilterTable(broad, 1, pairs, 1);
  settings.mMaxBodies = 8;
  return new jolt.JoltInterface(settings).GetPhysicsSystem().GetBodyInterface();
}
const world = makeWorld();
const scale = new jolt.Vec3(1, 1, 1), origin = new jolt.RVec3(0, 0, 0), filter = new jolt.ShapeFilter();
const collide = new jolt.CollideShapeSettings();
const place = new jolt.RVec3(0, 0, 0), turn = new jolt.Quat(0, 0, 0, 1);
let shapes = [], reach = [];

function makeShape(corners) {
  const h = halfSides(corners);
  if (h) return new jolt.BoxShape(new jolt.Vec3(...h), 0);
  const settings = new jolt.ConvexHullShapeSettings();
  settings.mMaxConvexRadius = 0;
  for (let i = 0; i < 24; i += 3) settings.mPoints.push_back(new jolt.Vec3(...corners.slice(i, i + 3)));
  const made = settings.Create();
  return made.HasError() ? null : made.Get();
}
function put(pose) {
  place.Set(...pose.p), turn.Set(...quaternion(pose.R));
}
const list = (v) => [v.GetX(), v.GetY(), v.GetZ()];

serve({ name: 'jolt', description: `Jolt (npm jolt-physics ${version}): TransformedShape.CollideShape`, distance: true, penetration: true,
  scalar_bits: 32, relative_resolution: 1e-5, depth_resolution: null },
(solids) => {
  shapes.forEach((shape) => shape?.Release());
  shapes = solids.map(makeShape);
  shapes.forEach((shape) => shape?.AddRef());
  reach = solids.map((corners) => Math.max(...[0, 3, 6, 9, 12, 15, 18, 21].map((i) => Math.hypot(...corners.slice(i, i + 3)))));
},
(question, a, b, X_WA, X_WB) => {
  if (!shapes[a] || !shapes[b]) return { status: UNSUPPORTED };
  put(X_WA);
  const settings = new jolt.BodyCreationSettings(shapes[a], place, turn, jolt.EMotionType_Static, LAYER);
  const body = world.CreateBody(settings);
  jolt.destroy(settings);
  const hits = new jolt.CollideShapeClosestHitCollisionCollector();
  put(X_WB);
  const X_WC = jolt.RMat44.prototype.sRotationTranslation(turn, place).PreTranslated(shapes[b].GetCenterOfMass());
  collide.mMaxSeparationDistance = question.query === OVERLAP ? 0 // farther than it need look makes it less accurate
    : Math.min(question.maxSeparation, Math.hypot(...X_WB.p.map((x, i) => x - X_WA.p[i])) + reach[a] + reach[b]);
  body.GetTransformedShape().CollideShape(shapes[b], scale, X_WC, collide, origin, hits, filter);
  let answer = { status: SEPARATED };
  if (hits.HadHit()) { // of B, as shape 1, against A
    const hit = hits.mHit, axis = list(hit.mPenetrationAxis), length = Math.hypot(...axis), separation = -hit.mPenetrationDepth;
    answer = { status: separation > 0 ? SEPARATED : OVERLAPPING, separation, n: axis.map((x) => -x / length), pA: list(hit.mContactPointOn2),
      pB: list(hit.mContactPointOn1) };
  }
  jolt.destroy(hits);
  world.DestroyBody(body.GetID());
  return answer;
});
