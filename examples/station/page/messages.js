// The station's text messages.

import {get, element, say, metres} from './panels.js';
import {Timeline} from './timeline.js';
import {parts, station, live, showsLive, troubleBriefly} from './state.js';
import {showFailedCameras, showSelected} from './screens.js';
import {openRecord} from './looking_back.js';
import {showLive} from './shown.js';
import {fetchMeshes} from './meshes.js';

// Pilots that are no page.
const pilots = {0xffffffff: 'datagrams fly', 0xfffffffe: 'the SpaceMouse flies', 0xfffffffd: 'a script flies'};

function takeHello(hello) {
  live.hello = hello;
  get('scenes').replaceChildren(...hello.scenes.map(({name, title}) => element('option', {value: name}, title || name)));
  get('scenes').value = hello.scene;
  if (!station.looking) showLive();
}

function takeScene(scene) {
  Object.assign(live, {scene, flight: new Timeline()});
  parts.panels.setLive(scene);
  parts.latency.clear();
  const tips = scene.tips || [];
  get('tip').replaceChildren(...tips.map((tip, i) => element('option', {value: String(i)}, tip.name)));
  get('tips').hidden = tips.length < 2;
  get('fault-cameras').replaceChildren(...scene.cameras.map((camera, i) => element('label', {className: 'check'},
    element('input', {type: 'checkbox', onchange: event => parts.link.control({fault: {kind: 'camera', camera: i, on: event.target.checked}})}), ` ${camera.name} fails`)));
  showRates(station.state);
  if (!station.looking) showLive();
  fetchMeshes(scene);
  if (live.hello?.record) openRecord();
}

// Which ends of an arm that walks are held; by both it cannot move.
function showHeld(held) {
  const scene = live.scene, name = ([tip, fixture]) => `${scene.tips[tip]?.name} is held by ${scene.objects[fixture]?.name}`;
  say(get('held'), !scene || !held.length ? '' : held.length < 2 ? held.map(name).join(', ') :
    `Both ends are held: ${held.map(name).join(', ')}. N chooses one, H lets it go.`);
}

// What full deflection commands, in the mode in force.
function showRates({mode, vernier, joint}) {
  const rates = live.scene?.rates, degrees = rate => `${(rate * 180 / Math.PI).toFixed(1)}°/s`;
  if (!rates) return say(get('rates'), '');
  const {translation, rotation} = vernier ? rates.vernier : rates.coarse, driven = parts.panels.liveJoints[joint];
  const ofJoint = driven?.kind === 'prismatic' ? `${metres(Math.min(rates.slide, driven.rate ?? Infinity))}/s` : degrees(Math.min(rates.joint, driven?.rate ?? Infinity));
  say(get('rates'), `Full deflection: ${mode === 'joint' ? ofJoint : `${metres(translation)}/s, ${degrees(rotation)}`}`);
}

function takeState(state) {
  station.state = state;
  const press = (id, on) => get(id).setAttribute('aria-pressed', String(Boolean(on)));
  press('brakes', state.brakes);
  press('vernier', state.vernier);
  press('mode', state.mode === 'joint');
  get('frame-of-command').value = state.frame_of_command;
  get('joint').value = String(state.joint ?? 0);
  get('tip').value = String(state.tip ?? 0);
  showRates(state);
  showHeld(state.held || []);
  get('jaws').hidden = !live.scene?.tips?.[state.tip ?? 0]?.jaws?.length;
  get('dynamics').checked = Boolean(state.dynamics);
  get('dynamics').disabled = !live.scene?.dynamics;
  for (const node of [get('policy').querySelector('[value=push]'), get('fault-torque')]) node.disabled = !state.dynamics;
  if (state.policy) get('policy').value = state.policy;
  if (state.scene) get('scenes').value = state.scene;
  say(get('pilot'), !(state.pilot > 0) ? '' : state.pilot === parts.link.client ? 'you fly' : pilots[state.pilot] || `client ${state.pilot} flies`);
  const faults = state.faults || [];
  say(get('faults'), faults.length ? `Faults: ${faults.map(fault => [fault.kind, fault.joint !== undefined ? parts.panels.liveJoints[fault.joint]?.name : '', fault.share ?? fault.delay ?? ''].filter(part => part !== '').join(' ')).join('; ')}` : 'No faults.');
  live.faults = faults;
  showFailedCameras();
  if (station.scene) showSelected();
}

export const takes = {
  hello: takeHello,
  scene: takeScene,
  state: takeState,
  event(event) { if (live.scene) parts.panels.addEvent(event); },
  score(score) { if (live.scene) parts.panels.showScore(score); },
  debrief(debrief) {
    parts.panels.showDebrief(debrief);
    if (showsLive()) parts.picture.path = (debrief.path || []).map(point => point.slice(1, 4));
    if (!get('debrief').open) get('debrief').showModal();
  },
  latency(message) { station.stages = message.stages_us; station.deadline = message.deadline; },
  error(message) { troubleBriefly(`The station says: ${message.text}`); }};
