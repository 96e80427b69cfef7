// The page's loop, the browser's own animation frame: take the newest frame, draw it, say when it was drawn.

import {get} from './panels.js';
import {looksLike, readFrame} from './frames.js';
import {parts, station, live} from './state.js';
import {aim, drawFrame} from './drawing.js';
import {showCue, showPanels} from './read_outs.js';
import {playOn} from './looking_back.js';

// A frame that came this long after it was sent lay in the browser while a turn was long; for a newer one the page waits so long at most [ms].
const long = 25, patience = 6;
const givenUp = 2000;  // a drawing that is not known to have ended is taken to have, so that pictures go on [ms]

function keep(list, value, most) {
  list.push(value);
  if (list.length > most) list.shift();
}

// Messages under way are no longer awaited.
export function forgetPending() {
  for (const {mark} of station.pending) if (mark) parts.renderer.forget(mark);
  station.pending = [];
}

// The page was hidden or is shown again. Turns stop while it is hidden: neither what was on its way then nor a hand that was obeyed
// meanwhile says how late pictures are.
export function rest() {
  awaitNoMore();
  forgetPending();
  parts.pace.rest();
  station.drawnAt = station.shownAt = null;
  const frame = parts.link.newest && readFrame(parts.link.newest);
  if (frame?.inputClient === parts.link.client) station.numberDrawn = Math.max(station.numberDrawn || 0, frame.inputNumber);
}

// A picture counts as drawn in the first turn in which the drawing has ended: it is on the screen then, as late as the page can know.
// One without a frame is of what is looked back at, or of CCTV that waited: it is no frame's first.
function accountForDrawn(now) {
  while (station.pending.length) {
    const {frame, begun, mark} = station.pending[0];
    if (!parts.renderer.hasFinished(mark)) {
      if (now - begun <= givenUp) return;
      parts.renderer.forget(mark);
    }
    station.pending.shift();
    if (mark) parts.pace.add(now - begun, now);
    if (!frame) continue;
    keep(station.ages, parts.link.age(frame), 20);
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

// Draws `frame` where it has changed, or only a CCTV picture whose turn has come; the mark of what was drawn, or null.
function draw(frame, now, hasChanged) {
  if (!hasChanged && !parts.picture.comesUp()) return null;
  drawFrame(frame, hasChanged);
  station.drawnAt = now;
  return parts.renderer.mark();
}

// The live frame is drawn, unless it looks as what is on the screen: drawing that again, by software, takes the processor from the
// station beside.
function showFrame(frame, now) {
  const hasChanged = aim(frame) || station.dirty || !looksLike(station.frame, frame);
  station.frame = frame;
  showCue(frame);
  station.pending.push({frame, begun: now, mark: draw(frame, now, hasChanged)});
  if (station.shownAt) keep(station.intervals, now - station.shownAt, 20);
  station.drawnAt = station.shownAt = now;
}

// Without a new live frame: what is looked back at, a camera that was turned, CCTV that waits until nothing else is being drawn, as
// the next frame would wait for it.
function drawAgain(now) {
  const hasChanged = Boolean(station.dirty);
  if (!hasChanged && station.pending.length) return;
  if (hasChanged) aim(station.frame);
  const mark = draw(station.frame, now, hasChanged);
  if (mark) station.pending.push({frame: null, begun: now, mark});
}

const isShown = frame => !station.looking && frame.objects === station.scene.objects.length &&
  (station.scene.serial === undefined || frame.serial === station.scene.serial);

export function turnOfLoop(now) {
  requestAnimationFrame(turnOfLoop);
  parts.pace.turned(now);
  accountForDrawn(now);
  if (!station.scene || parts.renderer.lost) return;
  if (station.playing && station.frame) playOn(now);
  // No queue of pictures: while two are being drawn the newest frame waits, or a newer one takes its place.
  if (station.awaits || station.pending.length >= 2 || now - (station.drawnAt || 0) < parts.pace.level.apart) return;
  if (parts.link.newest && parts.link.underWay > long && parts.link.rtt < 1000 * patience) awaitNewer();
  else showNewest(now);
}

function awaitNoMore() {
  clearTimeout(station.awaits);
  station.awaits = parts.link.onFrame = null;
}

// The newest frame lay in the browser: the station hears only now that it was taken, and sends the newest that it has. That one is drawn,
// unless it takes too long to come; where the station is further away than that nothing is waited for.
function awaitNewer() {
  const show = () => {
    awaitNoMore();
    if (station.scene && !parts.renderer.lost) showNewest(performance.now());
  };
  station.awaits = setTimeout(show, patience);
  parts.link.onFrame = show;
}

function showNewest(now) {
  const buffer = parts.link.newest, frame = parts.link.take();
  if (frame) noticeLostScene(frame, now);
  if (frame && isShown(frame)) {
    live.flight.add(buffer);
    showFrame(frame, now);
  } else if (station.frame) drawAgain(now);
  showPanels(now);
}
