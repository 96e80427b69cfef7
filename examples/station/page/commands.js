// Commands by a single press: keys, buttons of the page and of a gamepad.

import {get} from './panels.js';
import {parts, station, live, redraw} from './state.js';
import {layScreens, steered} from './screens.js';
import {choose} from './shown.js';
import {look} from './looking_back.js';
import {setAssist} from './assist.js';

export const keys = {Space: 'brakes', KeyV: 'vernier', KeyM: 'mode', KeyT: 'frame', KeyG: 'latch', KeyN: 'tip', KeyH: 'release', Home: 'reset',
  KeyC: 'compare', KeyY: 'assist', KeyX: 'edges', KeyB: 'meshes', KeyZ: 'ghost', KeyP: 'play', BracketLeft: 'joint-back', BracketRight: 'joint-on',
  Digit1: 'method-0', Digit2: 'method-1', Digit3: 'method-2', Digit4: 'method-3', Slash: 'help', F1: 'help',
  ArrowLeft: 'look-left', ArrowRight: 'look-right', ArrowUp: 'look-up', ArrowDown: 'look-down', Equal: 'closer', NumpadAdd: 'closer',
  Minus: 'farther', NumpadSubtract: 'farther'};

function steerMain(dx, dy) {
  const focused = station.screens.find(screen => screen.element === document.activeElement);
  steered(focused || {}).turn(dx, dy);
  redraw();
}

function zoomMain(factor) {
  const focused = station.screens.find(screen => screen.element === document.activeElement);
  steered(focused || {}).zoom(factor);
  redraw();
}

function stepJoint(by) {
  const joints = parts.panels.liveJoints.length;
  if (joints) parts.link.control({mode: 'joint', joint: ((station.state.joint ?? 0) + by + joints) % joints});
}

const frames = ['end effector', 'base', 'camera'];

export function setFrame(name) {
  parts.link.control(name === 'camera' ? {frame_of_command: name, camera: mainAttitude()} : {frame_of_command: name});
}

export function mainAttitude() {
  const screen = station.screens.find(one => one.main);
  return screen?.shownCamera?.rotation || station.orbit.camera.rotation;
}

const commands = {
  brakes() { parts.link.control({brakes: !station.state.brakes}); },
  vernier() { parts.link.control({vernier: !station.state.vernier}); },
  mode() { parts.link.control(station.state.mode === 'joint' ? {mode: 'hand'} : {mode: 'joint', joint: station.state.joint ?? 0}); },
  frame() { setFrame(frames[(frames.indexOf(station.state.frame_of_command) + 1) % 3]); },
  tip() { parts.link.control({tip: ((station.state.tip ?? 0) + 1) % Math.max(1, live.scene?.tips?.length ?? 1)}); },
  latch() { parts.link.control({latch: true}); },
  release() { parts.link.control({release: true}); },
  reset() { parts.hand.letGo(); parts.link.control({reset: true}); parts.picture.path = null; },
  debrief() { parts.link.control({debrief: true}); },
  compare() {
    station.sideBySide = !station.sideBySide;
    get('compare').setAttribute('aria-pressed', String(station.sideBySide));
    layScreens();
  },
  assist() { setAssist(!station.assisting); },
  edges() { get('show-edges').click(); },
  meshes() { if (!get('meshes').hidden) get('show-meshes').click(); },
  ghost() { get('show-ghost').click(); },
  play() { if (station.flight.frames.length) look(!station.playing ? 'play' : 'stop'); },
  live() { look('live'); },
  help() { if (get('help').open) get('help').close(); else get('help').showModal(); },
  'joint-back'() { stepJoint(-1); },
  'joint-on'() { stepJoint(1); },
  'look-left'() { steerMain(-20, 0); }, 'look-right'() { steerMain(20, 0); },
  'look-up'() { steerMain(0, -20); }, 'look-down'() { steerMain(0, 20); },
  closer() { zoomMain(0.85); }, farther() { zoomMain(1 / 0.85); }};

export function command(name) {
  if (!station.hello || !station.scene) return;
  if (name.startsWith('method-')) return choose(Number(name.slice(7)));
  commands[name]();
}
