// Which flight is shown: the live one, or one that is looked back at.

import {get} from './panels.js';
import {Mounted} from './picture.js';
import {parts, station, live, showsLive, ours} from './state.js';
import {layScreens} from './screens.js';
import {showMeshes} from './meshes.js';

export function choose(method) {
  if (!station.hello || method >= station.hello.methods.length) return;
  station.shown = method;
  station.sideBySide = false;
  get('compare').setAttribute('aria-pressed', 'false');
  layScreens();
}

export function showHello(hello) {
  station.hello = hello;
  station.shown = ours();
  parts.panels.setMethods(hello.methods, choose);
}

export function showScene(scene) {
  station.scene = scene;
  station.frame = null;
  station.mounted = scene.cameras.map((camera, i) => new Mounted(camera, i));
  station.mainCamera = -1;
  station.selected = -1;
  station.framed = false;
  parts.picture.setScene(scene);
  parts.picture.path = null;
  showMeshes();
  parts.panels.setScene(scene);
  layScreens();
}

// The flight looked back at stays until one goes live.
export function showLive() {
  if (!live.scene) return;
  station.flight = live.flight;
  if (station.hello !== live.hello) showHello(live.hello);
  if (!showsLive()) showScene(live.scene);
}
