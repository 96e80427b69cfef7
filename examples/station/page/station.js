// The training station's page: what comes from the station is shown, what the hands do goes to it. Here the parts are made and
// bound to the page; each other file has one concept. The hands are sent by a timer beside the loop of pictures.

import {Link} from './link.js';
import {Hand} from './hand.js';
import {Renderer} from './renderer.js';
import {Picture} from './picture.js';
import {Pace} from './pace.js';
import {get, say} from './panels.js';
import {parts, station, live, theme, trouble, redraw} from './state.js';
import {layScreens} from './screens.js';
import {takes} from './messages.js';
import {keys, command, setFrame} from './commands.js';
import {sendHand} from './sending.js';
import {sweep} from './assist.js';
import {look, openFlight, saveFlight} from './looking_back.js';
import {turnOfLoop, forgetPending, rest} from './loop.js';

function bindPage() {
  for (const button of document.querySelectorAll('[data-command]')) button.addEventListener('click', () => command(button.dataset.command));
  for (const button of document.querySelectorAll('[data-axis]')) parts.hand.bindButton(button);
  get('sound').onclick = () => { parts.sound.on = !parts.sound.on; get('sound').setAttribute('aria-pressed', String(parts.sound.on)); parts.sound.apply(); };
  get('scenes').onchange = event => parts.link.control({scene: event.target.value});
  get('frame-of-command').onchange = event => setFrame(event.target.value);
  get('joint').onchange = event => parts.link.control({mode: 'joint', joint: Number(event.target.value)});
  get('tip').onchange = event => parts.link.control({tip: Number(event.target.value)});
  get('policy').onchange = event => parts.link.control({policy: event.target.value});
  const joint = () => Number(get('fault-joint').value);
  get('fault-brake').onchange = event => parts.link.control({fault: {kind: 'joint brake', joint: joint(), on: event.target.checked}});
  get('fault-torque').onchange = event => parts.link.control({fault: {kind: 'torque loss', joint: joint(), share: Number(event.target.value)}});
  get('dynamics').onchange = event => { parts.hand.letGo(); parts.link.control({dynamics: event.target.checked}); };
  get('fault-late').onchange = event => parts.link.control({fault: {kind: 'late report', delay: Number(event.target.value)}});
  get('off').onclick = () => {
    const object = Number(get('off-object').value);
    parts.link.control({select: {object, on: (station.state.selected_off || []).includes(object)}});
  };
  for (const id of ['show-ghost', 'show-edges', 'show-meshes', 'show-distances', 'follow', 'detail', 'theme']) get(id).addEventListener('change', () => { setTheme(); redraw(); });
  get('show-cctv').onchange = () => { if (station.scene) layScreens(); };
  get('keys').onchange = event => { parts.hand.enabled = event.target.checked; parts.hand.letGo(); };
  // A control chosen by mouse does not keep the keys that fly.
  for (const node of document.querySelectorAll('select, input[type="checkbox"]')) node.addEventListener('change', () => { if (!node.matches(':focus-visible')) node.blur(); });
  get('line').oninput = () => look('stop');
  get('keep').onclick = saveFlight;
  get('open').onchange = event => { if (event.target.files[0]) openFlight(event.target.files[0]); event.target.value = ''; };
  get('start').onclick = () => get('help').close();
  get('start-compare').onclick = () => { get('help').close(); if (!station.sideBySide) command('compare'); if (!station.assisting) command('assist'); };
  get('debrief-close').onclick = () => { get('debrief').close(); };
  matchMedia('(prefers-color-scheme: dark)').addEventListener('change', () => { setTheme(); redraw(); });
  document.addEventListener('visibilitychange', rest);
  new ResizeObserver(layAnew).observe(get('screens'));
}

function layAnew() {
  parts.picture.isMeasured = false;
  redraw();
}

function setTheme() {
  document.documentElement.dataset.theme = theme();
  parts.pace.fix(get('detail').value === 'auto' ? null : Number(get('detail').value));
}

function connect() {
  const token = new URLSearchParams(location.search).get('token');
  parts.link = new Link(`${location.protocol === 'https:' ? 'wss' : 'ws'}://${location.host}/socket${token ? `?token=${encodeURIComponent(token)}` : ''}`);
  parts.link.addEventListener('text', ({detail}) => takes[detail.type]?.(detail));
  parts.link.addEventListener('connection', ({detail: open}) => {
    get('link').dataset.open = String(open);
    say(get('link-text'), open ? 'connected' : 'connection lost: trying again');
    if (!open) { parts.sound.set('clear'); parts.hand.letGo(); }
    forgetPending();
    Object.assign(station, {lastInput: null, numberDrawn: 0});
  });
}

function start() {
  try {
    parts.renderer = new Renderer(get('canvas'));
  } catch (fault) {
    return trouble(`No pictures: ${fault.message}. Chromium and Firefox have it; in a machine without a graphics card start Chromium with --enable-unsafe-swiftshader.`);
  }
  parts.pace = new Pace(parts.renderer.software);
  parts.picture = new Picture(parts.renderer, parts.pace);
  parts.picture.warmUp();
  parts.hand = new Hand(keys, command, sendHand);
  setTheme();
  bindPage();
  connect();
  requestAnimationFrame(turnOfLoop);
  // Apart from the pictures: where these come slowly the hand is sent all the same, or the station would let go.
  setInterval(sendHand, 15);
  let known = false;
  try { known = localStorage.getItem('touchstone-station-known') === 'yes'; localStorage.setItem('touchstone-station-known', 'yes'); } catch { /* private mode: shown again */ }
  const asked = new URLSearchParams(location.search);
  if (!known && !asked.has('fly')) get('help').showModal();
  if (asked.has('sweep')) sweep();
}

// For tests and for the curious: everything at hand in the console.
window.touchstoneStation = {station, live, latency: parts.latency, sound: parts.sound, get timeline() { return station.flight; },
  get link() { return parts.link; }, get hand() { return parts.hand; }, get renderer() { return parts.renderer; }, get picture() { return parts.picture; }, get pace() { return parts.pace; }};
start();
