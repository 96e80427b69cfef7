// The arm flies itself to what is nearest, and pushes on: for who wants to see before flying. Any key of the hand ends it.

import {get, nameOf} from './panels.js';
import {turn, conjugate, scale, subtract, unit} from './algebra.js';
import {parts, station, ours, troubleBriefly} from './state.js';

export function setAssist(on) {
  station.assisting = on;
  if (on) {
    station.frameBefore = station.state.frame_of_command;
    station.assistDirection = [0, 0, 0];
    parts.hand.assist = [0, 0, 0];
    parts.link.control({frame_of_command: 'base', mode: 'hand', brakes: false, vernier: false});
  } else {
    parts.hand.assist = null;
    if (station.frameBefore) parts.link.control({frame_of_command: station.frameBefore});
  }
  get('assist').setAttribute('aria-pressed', String(on));
}

// The normal at which ours meets what is nearest, away from the hand; none where it has no contact with it yet.
function normalTo(frame, {a, b}) {
  const meets = frame.contacts.find(one => one.method === ours() && [one.a, one.b].includes(a) && [one.a, one.b].includes(b));
  return meets ? scale(meets.normal, meets.a === a ? 1 : -1) : [0, 0, 0];
}

function giveUp(why) {
  troubleBriefly(why);
  setAssist(false);
}

export function steerAssist() {
  const frame = station.frame;
  if (!frame) return;
  const base = station.state.base || station.scene.arms[0]?.base.rotation || [0, 0, 0, 1];
  const nearest = frame.distances[0];
  const isKnown = station.assistDirection.some(Boolean);
  if (!nearest && !isKnown) return giveUp('Nothing is within 2 m of the hand: fly nearer first.');
  // In contact the two points are one, and single precision says little of closer ones: the last direction goes on, at first the normal.
  if (nearest && nearest.separation > 0.002) station.assistDirection = unit(subtract(nearest.pointOnB, nearest.pointOnA));
  else if (!isKnown) station.assistDirection = normalTo(frame, nearest);
  if (!station.assistDirection.some(Boolean)) return giveUp(`${nameOf(station.scene, nearest.b)} is within 2 mm of the hand already: fly off it first.`);
  parts.hand.assist = turn(conjugate(base), station.assistDirection);
}

// `?sweep`, for figures of long flights: a hand that sweeps in all directions until the page goes.
export function sweep() {
  const start = performance.now();
  setInterval(() => {
    const seconds = (performance.now() - start) / 1000;
    parts.hand.assist = [11, 17, 23].map(period => Math.sin(2 * Math.PI * seconds / period));
  }, 20);
}
