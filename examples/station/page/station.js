// The training station's page: what comes from the station is shown, what the hands do goes to it. One loop, the browser's
// own animation frame: take the newest frame, draw it, say when it was drawn. The hands are sent by a timer beside it.

import {Link} from './link.js';
import {Hand} from './hand.js';
import {Renderer} from './renderer.js';
import {Picture, Orbit, Mounted} from './picture.js';
import {Panels, get, element, say, metres, blockedBy, cueOf} from './panels.js';
import {Sound} from './sound.js';
import {Latency} from './latency.js';
import {Timeline} from './timeline.js';
import {readFrame, looksLike, positionOf, rotationOf, flag} from './frames.js';
import {add, turn, conjugate, subtract, scale, length, unit} from './algebra.js';

const keys = {Space: 'brakes', KeyV: 'vernier', KeyM: 'mode', KeyT: 'frame', KeyG: 'latch', KeyH: 'release', Home: 'reset',
  KeyC: 'compare', KeyY: 'assist', KeyX: 'edges', KeyZ: 'ghost', KeyP: 'play', BracketLeft: 'joint-back', BracketRight: 'joint-on',
  Digit1: 'method-0', Digit2: 'method-1', Digit3: 'method-2', Digit4: 'method-3', Slash: 'help', F1: 'help',
  ArrowLeft: 'look-left', ArrowRight: 'look-right', ArrowUp: 'look-up', ArrowDown: 'look-down', Equal: 'closer', NumpadAdd: 'closer',
  Minus: 'farther', NumpadSubtract: 'farther'};

const station = {hello: null, scene: null, state: {}, frame: null, shown: 3, sideBySide: false, selected: -1, stages: null,
  screens: [], orbit: new Orbit(), mounted: [], mainCamera: -1, drawn: 0, broken: 0, ages: [], intervals: []};
// The station's last messages, whatever is shown: `station` has hello, scene and flight of what is, which may be looked back at.
const live = {hello: null, scene: null, flight: new Timeline(), faults: []};
station.flight = live.flight;
const panels = new Panels(), sound = new Sound(), latency = new Latency();
let link, hand, renderer, picture;

const showsLive = () => station.scene === live.scene;
const ours = () => Math.max(0, station.hello.methods.findIndex(method => method.name === 'ours'));
const oursOf = frame => frame.methods.find(method => method.index === ours()) || frame.methods[frame.methods.length - 1];
const theme = () => get('theme').value !== 'auto' ? get('theme').value : matchMedia('(prefers-color-scheme: dark)').matches ? 'dark' : 'light';

function trouble(text) {
  clearTimeout(station.briefly);
  say(get('trouble'), text);
  get('trouble').hidden = !text;
}

function troubleBriefly(text) {
  trouble(text);
  station.briefly = setTimeout(() => trouble(''), 6000);
}

// ---- screens

// `screen`: {element, fact, camera(poses), method, main, mounted}
function makeScreen(parent, name, screen) {
  const fact = element('span', {className: 'fact'});
  const node = element('div', {className: 'screen', tabIndex: 0}, element('span', {className: 'name'}, name), fact);
  node.setAttribute('role', 'group');
  node.setAttribute('aria-label', `Picture: ${name}. Arrow keys turn the camera, plus and minus zoom.`);
  parent.append(node);
  Object.assign(screen, {element: node, fact, name});
  bindPointer(screen);
  station.screens.push(screen);
}

function steered(screen) {
  return screen.mounted || (station.mainCamera >= 0 ? station.mounted[station.mainCamera] : station.orbit);
}

function bindPointer(screen) {
  const fingers = new Map();
  let moved = 0;
  const node = screen.element;
  node.addEventListener('pointerdown', event => { fingers.set(event.pointerId, event); moved = 0; node.setPointerCapture(event.pointerId); });
  node.addEventListener('pointermove', event => {
    const last = fingers.get(event.pointerId);
    if (!last) return;
    const dx = event.clientX - last.clientX, dy = event.clientY - last.clientY;
    moved += Math.abs(dx) + Math.abs(dy);
    if (fingers.size === 1) steered(screen).turn(dx, dy);
    if (fingers.size === 2) {
      const other = [...fingers.values()].find(finger => finger.pointerId !== event.pointerId);
      const span = finger => Math.max(20, Math.hypot(finger.clientX - other.clientX, finger.clientY - other.clientY));
      steered(screen).zoom(span(last) / span(event));
    }
    fingers.set(event.pointerId, event);
    redraw();
  });
  const end = event => {
    if (event.type === 'pointerup' && fingers.size === 1 && moved < 6) click(screen, event);
    fingers.delete(event.pointerId);
  };
  node.addEventListener('pointerup', end);
  node.addEventListener('pointercancel', end);
  node.addEventListener('wheel', event => { event.preventDefault(); steered(screen).zoom(Math.exp(event.deltaY * 0.001)); redraw(); }, {passive: false});
  node.addEventListener('dblclick', () => { if (screen.mounted) lookThrough(station.mainCamera === screen.mounted.index ? -1 : screen.mounted.index); else lookThrough(-1); });
}

// The main screen looks through a camera of the scene, or circles (-1).
function lookThrough(index) {
  station.mainCamera = index;
  for (const screen of station.screens) if (screen.main) say(screen.element.firstChild, mainName(screen.method));
  redraw();
}

function mainName(method) {
  const camera = station.mainCamera >= 0 ? station.mounted[station.mainCamera].described.name : 'around the hand';
  return `${station.hello.methods[method].name} · ${camera}`;
}

// How deep merged, what blocks: on each screen in words.
function layScreens() {
  const {scene, hello} = station;
  station.screens = [];
  get('main-screens').replaceChildren();
  get('cctv').replaceChildren();
  get('main-screens').classList.toggle('four', station.sideBySide);
  const methods = station.sideBySide ? hello.methods.map((_, i) => i) : [station.shown];
  for (const method of methods)
    makeScreen(get('main-screens'), mainName(method), {method, main: true,
      camera: poses => station.mainCamera >= 0 ? station.mounted[station.mainCamera].at(poses) : station.orbit.camera});
  const small = station.sideBySide ? 0 : 4;
  station.mounted.slice(0, small).forEach(mounted => makeScreen(get('cctv'), mounted.described.name,
    {method: station.shown, mounted, camera: poses => mounted.at(poses)}));
  get('screens').classList.toggle('no-cctv', station.sideBySide || !get('show-cctv').checked || !scene.cameras.length);
  showFailedCameras();
  redraw();
}

function click(screen, event) {
  const frame = station.frame;
  if (!frame) return;
  const method = frame.methods.find(one => one.index === screen.method) || oursOf(frame);
  station.selected = picture.pick(screen, event.clientX, event.clientY, method.poses);
  const object = station.scene.objects[station.selected];
  if (object?.selectable && showsLive()) get('off-object').value = String(station.selected);
  showSelected();
}

function showSelected() {
  const object = station.scene.objects[station.selected];
  const off = showsLive() && (station.state.selected_off || []).includes(station.selected);
  say(get('selected'), object ? `${object.name}: ${object.kind}, ${object.solids.length} hexahedra, ${off ? 'not checked' : 'checked'}` :
    'Click a thing in the picture to select it.');
}

function showFailedCameras() {
  for (const screen of station.screens)
    screen.failed = Boolean(screen.mounted) && showsLive() && live.faults.some(fault => fault.kind === 'camera' && fault.camera === screen.mounted.index && fault.on !== false);
}

function showHello(hello) {
  station.hello = hello;
  station.shown = ours();
  panels.setMethods(hello.methods, choose);
}

function showScene(scene) {
  station.scene = scene;
  station.frame = null;
  station.mounted = scene.cameras.map((camera, i) => new Mounted(camera, i));
  station.mainCamera = -1;
  station.selected = -1;
  station.framed = false;
  picture.setScene(scene);
  picture.path = null;
  panels.setScene(scene);
  layScreens();
}

// The flight looked back at stays until one goes live.
function showLive() {
  if (!live.scene) return;
  station.flight = live.flight;
  if (station.hello !== live.hello) showHello(live.hello);
  if (!showsLive()) showScene(live.scene);
}

// ---- what the station says

function takeHello(hello) {
  live.hello = hello;
  get('scenes').replaceChildren(...hello.scenes.map(({name, title}) => element('option', {value: name}, title || name)));
  get('scenes').value = hello.scene;
  if (!station.looking) showLive();
}

function takeScene(scene) {
  Object.assign(live, {scene, flight: new Timeline()});
  panels.setLive(scene);
  latency.clear();
  get('fault-cameras').replaceChildren(...scene.cameras.map((camera, i) => element('label', {className: 'check'},
    element('input', {type: 'checkbox', onchange: event => link.control({fault: {kind: 'camera', camera: i, on: event.target.checked}})}), ` ${camera.name} fails`)));
  if (!station.looking) showLive();
}

function takeState(state) {
  station.state = state;
  const press = (id, on) => get(id).setAttribute('aria-pressed', String(Boolean(on)));
  press('brakes', state.brakes);
  press('vernier', state.vernier);
  press('mode', state.mode === 'joint');
  get('frame-of-command').value = state.frame_of_command;
  get('joint').value = String(state.joint ?? 0);
  get('dynamics').checked = Boolean(state.dynamics);
  get('dynamics').disabled = !live.scene?.dynamics;
  for (const node of [get('policy').querySelector('[value=push]'), get('fault-torque')]) node.disabled = !state.dynamics;
  if (state.policy) get('policy').value = state.policy;
  if (state.scene) get('scenes').value = state.scene;
  say(get('pilot'), state.pilot === undefined || state.pilot === null || state.pilot < 0 ? '' : state.pilot === link.client ? 'you fly' : `client ${state.pilot} flies`);
  const faults = state.faults || [];
  say(get('faults'), faults.length ? `Faults: ${faults.map(fault => [fault.kind, fault.joint !== undefined ? panels.liveJoints[fault.joint]?.name : '', fault.share ?? fault.delay ?? ''].filter(part => part !== '').join(' ')).join('; ')}` : 'No faults.');
  live.faults = faults;
  showFailedCameras();
  if (station.scene) showSelected();
}

const takes = {
  hello: takeHello,
  scene: takeScene,
  state: takeState,
  event(event) { if (live.scene) panels.addEvent(event); },
  score(score) { if (live.scene) panels.showScore(score); },
  debrief(debrief) {
    panels.showDebrief(debrief);
    if (showsLive()) picture.path = (debrief.path || []).map(point => point.slice(1, 4));
    if (!get('debrief').open) get('debrief').showModal();
  },
  latency(message) { station.stages = message.stages_us; station.deadline = message.deadline; },
  error(message) { troubleBriefly(`The station says: ${message.text}`); }};

// ---- what the hands do

function choose(method) {
  if (!station.hello || method >= station.hello.methods.length) return;
  station.shown = method;
  station.sideBySide = false;
  get('compare').setAttribute('aria-pressed', 'false');
  layScreens();
}

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
  const joints = panels.liveJoints.length;
  if (joints) link.control({mode: 'joint', joint: ((station.state.joint ?? 0) + by + joints) % joints});
}

const frames = ['end effector', 'base', 'camera'];

function setFrame(name) {
  link.control(name === 'camera' ? {frame_of_command: name, camera: mainAttitude()} : {frame_of_command: name});
}

function mainAttitude() {
  const screen = station.screens.find(one => one.main);
  return screen?.shownCamera?.rotation || station.orbit.camera.rotation;
}

const commands = {
  brakes() { link.control({brakes: !station.state.brakes}); },
  vernier() { link.control({vernier: !station.state.vernier}); },
  mode() { link.control(station.state.mode === 'joint' ? {mode: 'hand'} : {mode: 'joint', joint: station.state.joint ?? 0}); },
  frame() { setFrame(frames[(frames.indexOf(station.state.frame_of_command) + 1) % 3]); },
  latch() { link.control({latch: true}); },
  release() { link.control({release: true}); },
  reset() { hand.letGo(); link.control({reset: true}); picture.path = null; },
  debrief() { link.control({debrief: true}); },
  compare() {
    station.sideBySide = !station.sideBySide;
    get('compare').setAttribute('aria-pressed', String(station.sideBySide));
    layScreens();
  },
  assist() { setAssist(!station.assisting); },
  edges() { get('show-edges').click(); },
  ghost() { get('show-ghost').click(); },
  play() { if (station.flight.frames.length) look(!station.playing ? 'play' : 'stop'); },
  live() { look('live'); },
  help() { if (get('help').open) get('help').close(); else get('help').showModal(); },
  'joint-back'() { stepJoint(-1); },
  'joint-on'() { stepJoint(1); },
  'look-left'() { steerMain(-20, 0); }, 'look-right'() { steerMain(20, 0); },
  'look-up'() { steerMain(0, -20); }, 'look-down'() { steerMain(0, 20); },
  closer() { zoomMain(0.85); }, farther() { zoomMain(1 / 0.85); }};

function command(name) {
  if (!station.hello || !station.scene) return;
  if (name.startsWith('method-')) return choose(Number(name.slice(7)));
  commands[name]();
}

// The arm flies itself to what is nearest, and pushes on: for who wants to see before flying. Any key of the hand ends it.
function setAssist(on) {
  station.assisting = on;
  if (on) {
    station.frameBefore = station.state.frame_of_command;
    station.assistDirection = [0, 0, 0];
    hand.assist = [0, 0, 0];
    link.control({frame_of_command: 'base', mode: 'hand', brakes: false, vernier: false});
  } else {
    hand.assist = null;
    if (station.frameBefore) link.control({frame_of_command: station.frameBefore});
  }
  get('assist').setAttribute('aria-pressed', String(on));
}

function steerAssist() {
  const frame = station.frame;
  if (!frame) return;
  const base = station.scene.arms[0]?.base.rotation || [0, 0, 0, 1];
  const nearest = frame.distances[0];
  // In contact the two points are one, and single precision says little of closer ones: the last direction goes on.
  if (nearest && nearest.separation > 0.002) station.assistDirection = unit(subtract(nearest.pointOnB, nearest.pointOnA));
  hand.assist = turn(conjugate(base), station.assistDirection);
}

const same = (a, b) => a && ['translation', 'rotation'].every(k => a[k].every((value, i) => value === b[k][i])) && a.joint === b.joint;

// Sends what the hands hold: when it changed, and every 100 ms while it is off zero (the station lets go after 500 ms).
function sendHand() {
  if (!station.scene || !link.open || station.looking) return;
  const held = hand.read();
  if (station.assisting && hand.assist) steerAssist();
  else if (station.assisting) setAssist(false);  // the hand took over
  const input = {translation: [...held.translation], rotation: [...held.rotation], joint: held.joint};
  if (station.state.frame_of_command === 'camera') {
    // The camera's axes point right, up and backwards; the hand's forward, left and up.
    for (const vector of ['translation', 'rotation']) input[vector] = [-held[vector][1], held[vector][2], -held[vector][0]];
  }
  const zero = ![...input.translation, ...input.rotation, input.joint].some(Boolean);
  const now = performance.now();
  if (same(station.lastInput, input) && (zero || now - station.lastSent < 100)) return;
  if (station.state.frame_of_command === 'camera' && !zero) link.control({camera: mainAttitude(), frame_of_command: 'camera'});
  link.input(input);
  Object.assign(station, {lastInput: input, lastSent: now});
  for (const button of document.querySelectorAll('[data-axis]'))
    button.classList.toggle('held', hand.held.has(button.dataset.axis) || hand.pressed.has(button));
}

// ---- looking back

function look(what) {
  station.playing = what === 'play';
  station.looking = what !== 'live';
  if (what === 'live') showLive();
  if (what === 'play' && Number(get('line').value) >= station.flight.frames.length - 1) get('line').value = '0';
  get('live').setAttribute('aria-pressed', String(!station.looking));
  get('play').setAttribute('aria-pressed', String(station.playing));
  if (station.looking) hand.letGo();
  showLine();
}

function showLine() {
  const line = get('line'), last = Math.max(0, station.flight.frames.length - 1);
  if (Number(line.max) !== last) line.max = String(last);
  if (!station.looking) {
    line.value = String(last);
    return say(get('at'), 'live');
  }
  const buffer = station.flight.frames[Number(line.value)];
  const frame = buffer && readFrame(buffer);
  if (!frame) return;
  station.frame = frame;
  say(get('at'), `frame ${frame.frame}, ${frame.time.toFixed(2)} s`);
  line.setAttribute('aria-valuetext', `${frame.time.toFixed(2)} seconds`);
  redraw();
}

async function openFlight(file) {
  try {
    const flight = new Timeline(), {hello, scene} = flight.open(await file.arrayBuffer());
    station.flight = flight;
    showHello(hello);
    showScene(scene);
    get('line').value = '0';
    look('stop');
    trouble('');
  } catch (fault) {
    troubleBriefly(`Not opened: ${fault.message}`);
  }
}

function saveFlight() {
  const link = element('a', {href: URL.createObjectURL(station.flight.file(station.hello, station.scene)), download: `${station.scene.name}.tsf`});
  link.click();
  setTimeout(() => URL.revokeObjectURL(link.href), 10000);
}

// ---- the loop

function redraw() {
  station.dirty = true;
}

// The flown frame in the world: the arm's tip, or the free object that is flown.
function handPose(frame) {
  const {poses} = oursOf(frame), arm = station.scene.arms[0];
  const object = arm ? arm.tip.object : station.scene.solids[frame.distances[0]?.a]?.object;
  if (object === undefined) return null;
  const rotation = rotationOf(poses, object);
  return {position: add(positionOf(poses, object), arm ? turn(rotation, arm.tip.position) : [0, 0, 0]), rotation};
}

// The main camera starts beside the hand and a little behind it, and follows the hand. Whether it moved.
function aim(frame) {
  const tip = handPose(frame);
  if (!tip) return false;
  if (!station.framed) {
    station.framed = true;
    station.orbit.target = tip.position;
    station.orbit.distance = 5;
    const ahead = turn(tip.rotation, [1, 0, 0]);
    if (Math.hypot(ahead[0], ahead[1]) > 0.2) station.orbit.azimuth = Math.atan2(ahead[1], ahead[0]) - 2.0;
  }
  const way = subtract(tip.position, station.orbit.target);
  const moves = get('follow').checked && length(way) > 1e-4 * station.orbit.distance;  // less is less than a pixel
  if (moves) station.orbit.target = add(station.orbit.target, scale(way, 0.15));
  picture.focus = station.orbit.target;
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

function showLabels(frame) {
  const screen = station.screens.find(one => one.main && one.method === ours());
  const shown = !screen || !get('show-distances').checked || station.sideBySide ? [] : frame.distances.slice(0, 3);
  const labels = get('labels');
  while (labels.children.length < 3) labels.append(element('span'));
  const taken = [];
  for (let i = 0; i < 3; ++i) {
    const one = shown[i], at = one && picture.place(screen, scale(add(one.pointOnA, one.pointOnB), 0.5));
    // A farther one's label gives way to a nearer one's.
    const free = at && taken.every(other => Math.abs(at[0] - other[0]) > 64 || Math.abs(at[1] - other[1]) > 18);
    labels.children[i].hidden = !free;
    if (!free) continue;
    taken.push(at);
    say(labels.children[i], metres(one.separation));
    labels.children[i].style.transform = `translate(${(at[0] + screen.element.offsetLeft + 8).toFixed(0)}px, ${(at[1] + screen.element.offsetTop - 8).toFixed(0)}px)`;
  }
}

function drawFrame(frame) {
  Object.assign(picture, {edges: get('show-edges').checked, ghost: get('show-ghost').checked, distances: get('show-distances').checked});
  picture.draw(frame, station.screens, theme());
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

// The light and the tone follow each frame; the read-outs at most ten times a second, so that they can be read.
function showCue(frame) {
  const method = frame.methods.find(one => one.index === station.shown) || oursOf(frame);
  const [cue, nearness] = station.looking ? ['clear', 0] : cueOf(frame, method);
  const light = method.depth > 0 ? 'merged' : cue;
  if (get('light').dataset.cue !== light) get('light').dataset.cue = light;
  say(get('cue'), light === 'blocked' ? blockedBy(station.scene, method) : light);
  sound.set(cue, nearness);
}

function showPanels(now) {
  if (now - (station.panelsAt || 0) < 100 || !station.frame) return;
  station.panelsAt = now;
  const frame = station.frame, method = frame.methods.find(one => one.index === station.shown) || oursOf(frame);
  panels.showMethods(frame, station.shown, station.sideBySide);
  panels.showContact(frame, method);
  panels.showJoints(frame, station.state.joint ?? 0, station.state.mode === 'joint');
  if (!station.looking) showLine();
  if (now - (station.latencyAt || 0) > 500) {
    station.latencyAt = now;
    panels.showLatency(latency, station.stages);
    const [fps, age] = [station.intervals, station.ages].map(list => list.reduce((a, b) => a + b, 0) / Math.max(1, list.length));
    say(get('counts'), `${fps > 0 ? (1000 / fps).toFixed(0) : '–'} pictures a second, ${age > 0 ? (age / 1000).toFixed(0) : '–'} ms old when drawn; ` +
      `frames left out for newer ones: ${frame.overwritten + link.undrawn}; deadlines missed: ${frame.missed}` +
      (hand.padName ? `; gamepad: ${hand.padName.slice(0, 24)}` : ''));
  }
}

// Fewer pixels, down to half each way, where drawing (by software, mostly) does not reach 22 pictures a second.
function setDetail() {
  const wanted = get('detail').value;
  if (wanted !== 'auto') return void (renderer.detail = Number(wanted));
  if (station.intervals.length < 20) return;
  const middle = [...station.intervals].sort((a, b) => a - b)[10];
  if (middle > 45 && renderer.detail > 0.5) renderer.detail = Math.max(0.5, renderer.detail * 0.75);
  else return;
  station.intervals = [];
}

function keep(list, value, most) {
  list.push(value);
  if (list.length > most) list.shift();
}

// The picture drawn last turn is on the screen by now: its time is taken here, as late as the page can know.
function accountForDrawn(now) {
  const pending = station.pending;
  if (!pending) return;
  station.pending = null;
  const {frame} = pending;
  keep(station.ages, link.age(frame), 20);
  if (frame.inputClient !== link.client || frame.inputNumber <= (station.numberDrawn || 0) || !Number.isFinite(frame.inputStamp)) return;
  station.numberDrawn = frame.inputNumber;
  const stamp = performance.now() * 1000;
  latency.add((stamp - frame.inputStamp) / 1000);
  link.drawn(frame.frame, stamp);
}

// Frames of a newer scene than the one known for a second: its text was lost. A new connection begins with it.
function noticeLostScene(frame, now) {
  if (!(frame.serial > live.scene?.serial)) station.behindSince = null;
  else if (now - (station.behindSince ??= now) > 1000) {
    station.behindSince = null;
    link.socket.close();
  }
}

function turnOfLoop(now) {
  requestAnimationFrame(turnOfLoop);
  accountForDrawn(now);
  if (!station.scene || renderer.lost) return;
  const buffer = link.newest, frame = link.take();
  if (frame) noticeLostScene(frame, now);
  if (frame && !station.looking && frame.objects === station.scene.objects.length && (station.scene.serial === undefined || frame.serial === station.scene.serial)) {
    live.flight.add(buffer);
    // An unchanged picture is on the screen: drawing it again, by software, takes the processor from the station beside.
    const drawn = aim(frame) || station.dirty || !looksLike(station.frame, frame);
    station.frame = frame;
    showCue(frame);
    if (drawn) drawFrame(frame);
    if (station.drawnAt) keep(station.intervals, now - station.drawnAt, 20);
    station.drawnAt = now;
    station.pending = {frame};
    setDetail();
  } else if (station.frame && (station.dirty || station.playing)) {
    if (station.playing) playOn(now);
    aim(station.frame);
    drawFrame(station.frame);
  }
  showPanels(now);
}

// At the speed at which it was flown.
function playOn(now) {
  const line = get('line'), at = Number(line.value);
  if (at >= station.flight.frames.length - 1) return look('stop');
  const next = readFrame(station.flight.frames[at + 1]);
  station.playFrom = station.playFrom && now - station.playFrom < 1000 ? station.playFrom : now;
  const gap = next ? (next.time - station.frame.time) * 1000 : 0;
  if (now - station.playFrom < gap && gap < 1000) return;
  station.playFrom = now;
  line.value = String(at + 1);
  showLine();
}

// ---- bringing up

function bindPage() {
  for (const button of document.querySelectorAll('[data-command]')) button.addEventListener('click', () => command(button.dataset.command));
  for (const button of document.querySelectorAll('[data-axis]')) hand.bindButton(button);
  get('sound').onclick = () => { sound.on = !sound.on; get('sound').setAttribute('aria-pressed', String(sound.on)); sound.apply(); };
  get('scenes').onchange = event => link.control({scene: event.target.value});
  get('frame-of-command').onchange = event => setFrame(event.target.value);
  get('joint').onchange = event => link.control({mode: 'joint', joint: Number(event.target.value)});
  get('policy').onchange = event => link.control({policy: event.target.value});
  const joint = () => Number(get('fault-joint').value);
  get('fault-brake').onchange = event => link.control({fault: {kind: 'joint brake', joint: joint(), on: event.target.checked}});
  get('fault-torque').onchange = event => link.control({fault: {kind: 'torque loss', joint: joint(), share: Number(event.target.value)}});
  get('dynamics').onchange = event => { hand.letGo(); link.control({dynamics: event.target.checked}); };
  get('fault-late').onchange = event => link.control({fault: {kind: 'late report', delay: Number(event.target.value)}});
  get('off').onclick = () => {
    const object = Number(get('off-object').value);
    link.control({select: {object, on: (station.state.selected_off || []).includes(object)}});
  };
  for (const id of ['show-ghost', 'show-edges', 'show-distances', 'follow', 'detail', 'theme']) get(id).addEventListener('change', () => { setTheme(); redraw(); });
  get('show-cctv').onchange = () => { if (station.scene) layScreens(); };
  get('keys').onchange = event => { hand.enabled = event.target.checked; hand.letGo(); };
  // A control chosen by mouse does not keep the keys that fly.
  for (const node of document.querySelectorAll('select, input[type="checkbox"]')) node.addEventListener('change', () => { if (!node.matches(':focus-visible')) node.blur(); });
  get('line').oninput = () => look('stop');
  get('keep').onclick = saveFlight;
  get('open').onchange = event => { if (event.target.files[0]) openFlight(event.target.files[0]); event.target.value = ''; };
  get('start').onclick = () => get('help').close();
  get('start-compare').onclick = () => { get('help').close(); if (!station.sideBySide) command('compare'); if (!station.assisting) command('assist'); };
  get('debrief-close').onclick = () => { get('debrief').close(); };
  matchMedia('(prefers-color-scheme: dark)').addEventListener('change', () => { setTheme(); redraw(); });
  new ResizeObserver(redraw).observe(get('screens'));
}

function setTheme() {
  document.documentElement.dataset.theme = theme();
  renderer.detail = get('detail').value === 'auto' ? renderer.detail || (renderer.software ? 0.6 : 1) : Number(get('detail').value);
}

function connect() {
  const token = new URLSearchParams(location.search).get('token');
  link = new Link(`${location.protocol === 'https:' ? 'wss' : 'ws'}://${location.host}/socket${token ? `?token=${encodeURIComponent(token)}` : ''}`);
  link.addEventListener('text', ({detail}) => takes[detail.type]?.(detail));
  link.addEventListener('connection', ({detail: open}) => {
    get('link').dataset.open = String(open);
    say(get('link-text'), open ? 'connected' : 'connection lost: trying again');
    if (!open) { sound.set('clear'); hand.letGo(); }
    Object.assign(station, {lastInput: null, numberDrawn: 0, pending: null});
  });
}

function start() {
  try {
    renderer = new Renderer(get('canvas'));
  } catch (fault) {
    return trouble(`No pictures: ${fault.message}. Chromium and Firefox have it; in a machine without a graphics card start Chromium with --enable-unsafe-swiftshader.`);
  }
  picture = new Picture(renderer);
  hand = new Hand(keys, command, sendHand);
  setTheme();
  bindPage();
  connect();
  requestAnimationFrame(turnOfLoop);
  // Apart from the pictures: where these come slowly the hand is sent all the same, or the station would let go.
  setInterval(sendHand, 15);
  let known = false;
  try { known = localStorage.getItem('touchstone-station-known') === 'yes'; localStorage.setItem('touchstone-station-known', 'yes'); } catch { /* private mode: shown again */ }
  if (!known && !new URLSearchParams(location.search).has('fly')) get('help').showModal();
}

// For tests and for the curious: everything at hand in the console.
window.touchstoneStation = {station, live, latency, sound, get timeline() { return station.flight; }, get link() { return link; }, get hand() { return hand; }, get renderer() { return renderer; }, get picture() { return picture; }};
start();
