// A frame on the screens: where the main camera looks, what is drawn, what each screen says.

import {get, element, say, metres, blockedBy} from './panels.js';
import {positionOf, rotationOf} from './frames.js';
import {add, turn, subtract, scale, length} from './algebra.js';
import {parts, station, ours, oursOf, theme} from './state.js';

// The flown frame in the world: the arm's tip, or the free object that is flown.
function handPose(frame) {
  const {poses} = oursOf(frame), arm = station.scene.arms[0];
  const tip = station.scene.tips?.[frame.tip] || arm?.tip;
  const object = tip ? tip.object : station.scene.solids[frame.distances[0]?.a]?.object;
  if (object === undefined) return null;
  const rotation = rotationOf(poses, object);
  return {position: add(positionOf(poses, object), tip ? turn(rotation, tip.position) : [0, 0, 0]), rotation};
}

// The main camera starts beside the hand and a little behind it, and follows the hand. Whether it moved.
export function aim(frame) {
  const tip = handPose(frame);
  if (!tip) return false;
  if (!station.framed) {
    station.framed = true;
    station.orbit.target = tip.position;
    station.orbit.distance = Math.max(0.2, station.scene.view || 5);  // records of before have none
    const ahead = turn(tip.rotation, [1, 0, 0]);
    if (Math.hypot(ahead[0], ahead[1]) > 0.2) station.orbit.azimuth = Math.atan2(ahead[1], ahead[0]) - 2.0;
  }
  const way = subtract(tip.position, station.orbit.target);
  const moves = get('follow').checked && length(way) > 1e-4 * station.orbit.distance;  // less is less than a pixel
  if (moves) station.orbit.target = add(station.orbit.target, scale(way, 0.15));
  parts.picture.focus = station.orbit.target;
  return moves;
}

function factOf(frame, screen) {
  const method = frame.methods.find(one => one.index === screen.method);
  if (screen.failed) return 'no picture: camera failed';
  if (!method) return 'not run';
  if (method.depth > 0) return `MERGED ${metres(method.depth)}`;
  if (!screen.main) return '';
  if (method.blocked) return blockedBy(station.scene, method);
  if (station.sideBySide && method.worst > 0) return `was merged by up to ${metres(method.worst)}`;
  return method.contact ? 'in contact' : '';
}

// They go with the picture; their figures change as often as the other read-outs do.
function showLabels(frame) {
  const now = performance.now(), isDue = now - (station.labelsAt || 0) >= 1000 / parts.pace.level.readOuts;
  if (isDue) station.labelsAt = now;
  const screen = station.screens.find(one => one.main && one.method === ours());
  const shown = !screen || !get('show-distances').checked || station.sideBySide ? [] : frame.distances.slice(0, 3);
  const labels = get('labels');
  while (labels.children.length < 3) labels.append(element('span'));
  const taken = [];
  for (let i = 0; i < 3; ++i) {
    const one = shown[i], at = one && parts.picture.place(screen, scale(add(one.pointOnA, one.pointOnB), 0.5));
    // A farther one's label gives way to a nearer one's.
    const free = at && taken.every(other => Math.abs(at[0] - other[0]) > 64 || Math.abs(at[1] - other[1]) > 18);
    const isNew = free && labels.children[i].hidden;
    labels.children[i].hidden = !free;
    if (!free) continue;
    taken.push(at);
    if (isDue || isNew) say(labels.children[i], metres(one.separation));
    labels.children[i].style.transform = `translate(${(at[0] + 8).toFixed(0)}px, ${(at[1] - 8).toFixed(0)}px)`;
  }
}

export function drawFrame(frame, hasChanged = true) {
  Object.assign(parts.picture, {edges: get('show-edges').checked, meshes: get('show-meshes').checked, ghost: get('show-ghost').checked, distances: get('show-distances').checked});
  parts.picture.draw(frame, station.screens, theme(), hasChanged);
  for (const screen of station.screens) {
    const method = frame.methods.find(one => one.index === screen.method);
    say(screen.fact, factOf(frame, screen));
    screen.element.classList.toggle('merged', Boolean(method && method.depth > 0));
    screen.element.classList.toggle('failed', Boolean(screen.failed));
  }
  showLabels(frame);
  ++station.drawn;
  station.dirty = false;
}
