// The time line: looks back, plays, saves flights and opens them again.

import {ask} from './meshes.js';
import {get, element, say} from './panels.js';
import {readFrame} from './frames.js';
import {Timeline} from './timeline.js';
import {parts, station, trouble, troubleBriefly, redraw} from './state.js';
import {showHello, showScene, showLive} from './shown.js';

export function look(what) {
  station.playing = what === 'play';
  station.looking = what !== 'live';
  if (what === 'live') showLive();
  if (what === 'play' && Number(get('line').value) >= station.flight.frames.length - 1) get('line').value = '0';
  get('live').setAttribute('aria-pressed', String(!station.looking));
  get('play').setAttribute('aria-pressed', String(station.playing));
  if (station.looking) parts.hand.letGo();
  showLine();
}

export function showLine() {
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

export async function openFlight(file) {
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

// A record that the station was given to be opened, once.
export async function openRecord() {
  if (station.hasOpenedRecord) return;
  station.hasOpenedRecord = true;
  const response = await ask('record.tsf');
  if (response.ok) await openFlight(response);
  else troubleBriefly('The record was not sent.');
}

export function saveFlight() {
  const link = element('a', {href: URL.createObjectURL(station.flight.file(station.hello, station.scene)), download: `${station.scene.name}.tsf`});
  link.click();
  setTimeout(() => URL.revokeObjectURL(link.href), 10000);
}

// At the speed at which it was flown.
export function playOn(now) {
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
