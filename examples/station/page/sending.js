// The hands' input, sent to the station.

import {parts, station} from './state.js';
import {setAssist, steerAssist} from './assist.js';
import {mainAttitude} from './commands.js';

const same = (a, b) => a && ['translation', 'rotation'].every(k => a[k].every((value, i) => value === b[k][i])) && a.joint === b.joint && a.grip === b.grip;

// Sends what the hands hold: when it changed, and every 100 ms while it is off zero (the station lets go after 500 ms).
export function sendHand() {
  if (!station.scene || !parts.link.open || station.looking) return;
  const held = parts.hand.read();
  if (station.assisting && parts.hand.assist) steerAssist();
  else if (station.assisting) setAssist(false);  // the hand took over
  const input = {translation: [...held.translation], rotation: [...held.rotation], joint: held.joint, grip: held.grip};
  if (station.state.frame_of_command === 'camera') {
    // The camera's axes point right, up and backwards; the hand's forward, left and up.
    for (const vector of ['translation', 'rotation']) input[vector] = [-held[vector][1], held[vector][2], -held[vector][0]];
  }
  const zero = ![...input.translation, ...input.rotation, input.joint, input.grip].some(Boolean);
  const now = performance.now();
  if (same(station.lastInput, input) && (zero || now - station.lastSent < 100)) return;
  if (station.state.frame_of_command === 'camera' && !zero) parts.link.control({camera: mainAttitude(), frame_of_command: 'camera'});
  parts.link.input(input);
  Object.assign(station, {lastInput: input, lastSent: now});
  for (const button of document.querySelectorAll('[data-axis]'))
    button.classList.toggle('held', parts.hand.held.has(button.dataset.axis) || parts.hand.pressed.has(button));
}
