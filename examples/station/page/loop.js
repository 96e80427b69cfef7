// The page's loop, the browser's own animation frame: take the newest frame, draw it, say when it was drawn.

import {get} from './panels.js';
import {looksLike} from './frames.js';
import {parts, station, live} from './state.js';
import {aim, drawFrame} from './drawing.js';
import {showCue, showPanels} from './read_outs.js';
import {playOn} from './looking_back.js';

const givenUp = 2000;  // a drawing that is not known to have ended is taken to have, so that pictures go on [ms]

function keep(list, value, most) {
  list.push(value);
  if (list.length > most) list.shift();
}

// A picture counts as drawn in the first turn in which the drawing has ended: it is on the screen then, as late as the page can know.
function accountForDrawn(now) {
  const hasEnded = ({mark, begun}) => parts.renderer.hasFinished(mark) || now - begun > givenUp;
  while (station.pending.length && hasEnded(station.pending[0])) {
    const {frame, begun, mark} = station.pending.shift();
    keep(station.ages, parts.link.age(frame), 20);
    if (mark) parts.pace.add(now - begun, now);
    if (frame.inputClient !== parts.link.client || frame.inputNumber <= (station.numberDrawn || 0) || !Number.isFinite(frame.inputStamp)) continue;
    station.numberDrawn = frame.inputNumber;
    const stamp = performance.now() * 1000;
    parts.latency.add((stamp - frame.inputStamp) / 1000);
    parts.link.drawn(frame.frame, stamp);
  }
}

// Frames of a newer scene than the one known for a second: its text was lost. A new connection begins with it.
function noticeLostScene(frame, now) {
  if (!(frame.serial > live.scene?.serial)) station.behindSince = null;
  else if (now - (station.behindSince ??= now) > 1000) {
    station.behindSince = null;
    parts.link.socket.close();
  }
}

// The live frame is drawn, unless it looks as what is on the screen: drawing that again, by software, takes the processor from the
// station beside.
function showFrame(frame, now) {
  const hasChanged = aim(frame) || station.dirty || !looksLike(station.frame, frame), drawn = hasChanged || parts.picture.stale.size > 0;
  station.frame = frame;
  showCue(frame);
  if (drawn) drawFrame(frame, hasChanged);
  if (station.drawnAt) keep(station.intervals, now - station.drawnAt, 20);
  station.drawnAt = now;
  station.pending.push({frame, begun: now, mark: drawn ? parts.renderer.mark() : null});
}

const isShown = frame => !station.looking && frame.objects === station.scene.objects.length &&
  (station.scene.serial === undefined || frame.serial === station.scene.serial);

export function turnOfLoop(now) {
  requestAnimationFrame(turnOfLoop);
  parts.pace.turned(now);
  accountForDrawn(now);
  // No queue of pictures: while two are being drawn the newest frame waits, or a newer one takes its place.
  if (!station.scene || parts.renderer.lost || station.pending.length >= 2 || now - (station.drawnAt || 0) < parts.pace.level.apart) return;
  const buffer = parts.link.newest, frame = parts.link.take();
  if (frame) noticeLostScene(frame, now);
  if (frame && isShown(frame)) {
    live.flight.add(buffer);
    showFrame(frame, now);
  } else if (station.frame && (station.dirty || station.playing || parts.picture.stale.size)) {
    if (station.playing) playOn(now);
    drawFrame(station.frame, aim(station.frame) || station.dirty || station.playing);
  }
  showPanels(now);
}
