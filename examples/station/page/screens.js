// The screens: the main pictures and CCTV, their cameras, and what is chosen in them.

import {get, element, say} from './panels.js';
import {parts, station, live, showsLive, oursOf, redraw} from './state.js';

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

export function steered(screen) {
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
export function layScreens() {
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
  parts.picture.isMeasured = false;
  parts.picture.stale.clear();
  showFailedCameras();
  redraw();
}

function click(screen, event) {
  const frame = station.frame;
  if (!frame) return;
  const method = frame.methods.find(one => one.index === screen.method) || oursOf(frame);
  station.selected = parts.picture.pick(screen, event.clientX, event.clientY, method.poses);
  const object = station.scene.objects[station.selected];
  if (object?.selectable && showsLive()) get('off-object').value = String(station.selected);
  showSelected();
}

export function showSelected() {
  const object = station.scene.objects[station.selected];
  const off = showsLive() && (station.state.selected_off || []).includes(station.selected);
  say(get('selected'), object ? `${object.name}: ${object.kind}, ${object.solids.length} hexahedra, ${off ? 'not checked' : 'checked'}` :
    'Click a thing in the picture to select it.');
}

export function showFailedCameras() {
  for (const screen of station.screens)
    screen.failed = Boolean(screen.mounted) && showsLive() && live.faults.some(fault => fault.kind === 'camera' && fault.camera === screen.mounted.index && fault.on !== false);
}
