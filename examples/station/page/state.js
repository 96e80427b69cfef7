// The page's state: the flight that is shown, what is live, and the parts that show it.

import {Panels, get, say} from './panels.js';
import {Orbit} from './picture.js';
import {Sound} from './sound.js';
import {Latency} from './latency.js';
import {Timeline} from './timeline.js';

export const station = {hello: null, scene: null, state: {}, frame: null, shown: 3, sideBySide: false, selected: -1, stages: null,
  screens: [], orbit: new Orbit(), mounted: [], mainCamera: -1, drawn: 0, broken: 0, ages: [], intervals: [], pending: [], awaits: null};
// The station's last messages, whatever is shown: `station` has hello, scene and flight of what is, which may be looked back at.
// `meshes`: that came last, by their path; they are no part of a scene, which is saved with a flight.
export const live = {hello: null, scene: null, flight: new Timeline(), faults: [], meshes: {path: null, list: []}};
station.flight = live.flight;

// `link`, `hand`, `renderer`, `pace` and `picture` come with the page: station.js.
export const parts = {panels: new Panels(), sound: new Sound(), latency: new Latency(), link: null, hand: null, renderer: null, pace: null, picture: null};

export const showsLive = () => station.scene === live.scene;

export const ours = () => Math.max(0, station.hello.methods.findIndex(method => method.name === 'ours'));

export const oursOf = frame => frame.methods.find(method => method.index === ours()) || frame.methods[frame.methods.length - 1];

export const theme = () => get('theme').value !== 'auto' ? get('theme').value : matchMedia('(prefers-color-scheme: dark)').matches ? 'dark' : 'light';

export function trouble(text) {
  clearTimeout(station.briefly);
  say(get('trouble'), text);
  get('trouble').hidden = !text;
}

export function troubleBriefly(text) {
  trouble(text);
  station.briefly = setTimeout(() => trouble(''), 6000);
}

export function redraw() {
  station.dirty = true;
}
