// The page's loop, the browser's own animation frame: take the newest frame, draw it, say when it was drawn.

import {get} from './panels.js';
import {looksLike} from './frames.js';
import {parts, station, live} from './state.js';
import {aim, drawFrame} from './drawing.js';
import {showCue, showPanels} from './read_outs.js';
import {playOn} from './looking_back.js';

// Fewer pixels, down to half each way, where drawing (by software, mostly) does not reach 22 pictures a second.
function setDetail() {
  const wanted = get('detail').value;
  if (wanted !== 'auto') return void (parts.renderer.detail = Number(wanted));
  if (station.intervals.length < 20) return;
  const middle = [...station.intervals].sort((a, b) => a - b)[10];
  if (middle > 45 && parts.renderer.detail > 0.5) parts.renderer.detail = Math.max(0.5, parts.renderer.detail * 0.75);
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
  keep(station.ages, parts.link.age(frame), 20);
  if (frame.inputClient !== parts.link.client || frame.inputNumber <= (station.numberDrawn || 0) || !Number.isFinite(frame.inputStamp)) return;
  station.numberDrawn = frame.inputNumber;
  const stamp = performance.now() * 1000;
  parts.latency.add((stamp - frame.inputStamp) / 1000);
  parts.link.drawn(frame.frame, stamp);
}

// Frames of a newer scene than the one known for a second: its text was lost. A new connection begins with it.
function noticeLostScene(frame, now) {
  if (!(frame.serial > live.scene?.serial)) station.behindSince = null;
  else if (now - (station.behindSince ??= now) > 1000) {
    station.behindSince = null;
    parts.link.socket.close();
  }
}

export function turnOfLoop(now) {
  requestAnimationFrame(turnOfLoop);
  accountForDrawn(now);
  if (!station.scene || parts.renderer.lost) return;
  const buffer = parts.link.newest, frame = parts.link.take();
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
