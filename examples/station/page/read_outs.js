// A frame in words, light and tone.

import {get, say, blockedBy, cueOf} from './panels.js';
import {parts, station, oursOf} from './state.js';
import {showLine} from './looking_back.js';

// The light and the tone follow each frame; the read-outs at most ten times a second, so that they can be read, and less often where time is short.
export function showCue(frame) {
  const method = frame.methods.find(one => one.index === station.shown) || oursOf(frame);
  const [cue, nearness] = station.looking ? ['clear', 0] : cueOf(frame, method);
  const light = method.depth > 0 ? 'merged' : cue;
  if (get('light').dataset.cue !== light) get('light').dataset.cue = light;
  say(get('cue'), light === 'blocked' ? blockedBy(station.scene, method) : light);
  parts.sound.set(cue, nearness);
}

export function showPanels(now) {
  if (now - (station.panelsAt || 0) < 1000 / parts.pace.level.readOuts || !station.frame) return;
  station.panelsAt = now;
  const frame = station.frame, method = frame.methods.find(one => one.index === station.shown) || oursOf(frame);
  parts.panels.showMethods(frame, station.shown, station.sideBySide);
  parts.panels.showContact(frame, method);
  parts.panels.showJoints(frame, station.state.joint ?? 0, station.state.mode === 'joint');
  if (!station.looking) showLine();
  if (now - (station.latencyAt || 0) > 500) {
    station.latencyAt = now;
    parts.panels.showLatency(parts.latency, station.stages);
    const [fps, age] = [station.intervals, station.ages].map(list => list.reduce((a, b) => a + b, 0) / Math.max(1, list.length));
    say(get('drawn-for-speed'), parts.pace.says(parts.renderer.meshes.length > 0));
    say(get('counts'), `${fps > 0 ? (1000 / fps).toFixed(0) : '–'} pictures a second, ${age > 0 ? (age / 1000).toFixed(0) : '–'} ms old when drawn; ` +
      `frames left out for newer ones: ${frame.overwritten + parts.link.undrawn}; deadlines missed: ${frame.missed}` +
      (parts.hand.padName ? `; gamepad: ${parts.hand.padName.slice(0, 24)}` : ''));
  }
}
