// The arm flies itself to what is nearest, and pushes on: for who wants to see before flying. Any key of the hand ends it.

import {get} from './panels.js';
import {turn, conjugate, subtract, unit} from './algebra.js';
import {parts, station, troubleBriefly} from './state.js';

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

export function steerAssist() {
  const frame = station.frame;
  if (!frame) return;
  const base = station.state.base || station.scene.arms[0]?.base.rotation || [0, 0, 0, 1];
  const nearest = frame.distances[0];
  // In contact the two points are one, and single precision says little of closer ones: the last direction goes on.
  if (nearest && nearest.separation > 0.002) station.assistDirection = unit(subtract(nearest.pointOnB, nearest.pointOnA));
  if (!station.assistDirection.some(Boolean)) {  // nothing is near, nor has been
    troubleBriefly('Nothing is within 2 m of the hand: fly nearer first.');
    return setAssist(false);
  }
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
