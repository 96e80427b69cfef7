// The picture: which objects in which colours, the marks of contacts and distances, and the cameras' views on one canvas.

import {add, subtract, scale, unit, length, turn, multiply, about, lookAt, project} from './algebra.js';
import {contactKind, objectFlag, positionOf, rotationOf} from './frames.js';

const palettes = {
  link: [[0.86, 0.88, 0.91], [0.76, 0.79, 0.84]],
  free: [[0.93, 0.72, 0.30], [0.55, 0.72, 0.86]],
  static: [[0.62, 0.66, 0.73], [0.72, 0.67, 0.57], [0.55, 0.60, 0.68], [0.66, 0.70, 0.72]]};
// Colours that stay apart in all common kinds of colour blindness (Okabe and Ito).
const colour = {merged: [1.0, 0.16, 0.14], contact: [0.90, 0.62, 0.0], blocked: [0.80, 0.40, 0.0], near: [0.94, 0.89, 0.26],
  force: [0.0, 0.62, 0.45], distance: [0.34, 0.71, 0.91], path: [0.80, 0.47, 0.65], commanded: [0.30, 0.72, 1.0]};
const sky = {dark: [0.035, 0.047, 0.075], light: [0.82, 0.87, 0.93]};
const bezel = {dark: [0.08, 0.09, 0.11], light: [0.93, 0.945, 0.96]};
// Around a screen; drawn here since the browser would blend it over all of the canvas. As --line and .bad of station.css.
const border = {dark: [0.23, 0.25, 0.29], light: [0.79, 0.82, 0.85], merged: [0.85, 0.11, 0.11]};

const mix = (a, b, share) => [0, 1, 2].map(i => a[i] + (b[i] - a[i]) * share);
const rgba = (rgb, alpha = 1) => [...rgb, alpha];

// Objects' own colours, from their kind and order.
export function coloursOf(objects) {
  const seen = {};
  return objects.map(({kind, name}) => {
    const palette = palettes[kind] || palettes.static;
    seen[kind] = (seen[kind] ?? -1) + 1;
    return /lee|tip|otcm|hand/i.test(name) && kind === 'link' ? [0.42, 0.50, 0.62] : palette[seen[kind] % palette.length];
  });
}

// The camera that circles what is looked at: dragged, or turned by the arrow keys.
export class Orbit {
  constructor() {
    Object.assign(this, {target: [0, 0, 0], azimuth: -0.9, elevation: 0.42, distance: 6});
  }
  turn(dx, dy) {
    this.azimuth -= dx * 0.006;
    this.elevation = Math.max(-1.5, Math.min(1.5, this.elevation + dy * 0.006));
  }
  zoom(factor) {
    this.distance = Math.max(0.2, Math.min(120, this.distance * factor));
  }
  get camera() {
    const flat = Math.cos(this.elevation);
    const eye = add(this.target, scale([flat * Math.cos(this.azimuth), flat * Math.sin(this.azimuth), Math.sin(this.elevation)], this.distance));
    return {position: eye, rotation: lookAt(eye, this.target), fov: 0.75, near: Math.min(this.distance / 10, Math.max(0.01, this.distance / 200)), far: 60 * this.distance + 200};
  }
}

// A camera of the scene: carried by an object, panned and tilted by whoever watches.
export class Mounted {
  constructor(described, index) {
    Object.assign(this, {described, index, pan: 0, tilt: 0, zoomed: 1});
    this.steerable = !/wrist|tip|lee/i.test(described.name);  // that one is bolted to the hand
  }
  turn(dx, dy) {
    if (!this.steerable) return;
    this.pan -= dx * 0.004;
    this.tilt = Math.max(-1.4, Math.min(1.4, this.tilt - dy * 0.004));
  }
  zoom(factor) {
    this.zoomed = Math.max(0.2, Math.min(1.6, this.zoomed * factor));
  }
  at(poses) {
    const {object, position, look, up, fov} = this.described;
    let rotation = lookAt([0, 0, 0], look, up || [0, 0, 1]), where = position;
    rotation = multiply(rotation, multiply(about([0, 1, 0], this.pan), about([1, 0, 0], this.tilt)));
    if (object >= 0) {
      where = add(positionOf(poses, object), turn(rotationOf(poses, object), position));
      rotation = multiply(rotationOf(poses, object), rotation);
    }
    return {position: where, rotation, fov: (fov || 0.8) * this.zoomed, near: 0.02, far: 300};
  }
}

// The objects that are merged deepest as `method` shows them: two or none.
export function mergedObjects(scene, method) {
  return new Set(method.depth > 0 ? method.deepest.filter(s => s >= 0).map(s => scene.solids[s]?.object) : []);
}

// Colours of a frame as `method` shows it: what is in contact, blocked or switched off is tinted.
export function frameColours(base, method) {
  return base.map((own, i) => {
    const flags = method.flags[8 * i + 7];
    if (flags & objectFlag.blocked) return rgba(mix(own, colour.blocked, 0.55));
    if (flags & objectFlag.contact) return rgba(mix(own, colour.contact, 0.5));
    if (flags & objectFlag.off) return rgba(mix(own, [0.5, 0.5, 0.5], 0.75));
    return rgba(own);
  });
}

// Which objects lag behind their command by more than 1 mm (or 0.1 degrees), and by how much the farthest does [m].
export function lagging(actual, commanded, count) {
  const shown = [];
  let farthest = 0;
  for (let i = 0; i < count; ++i) {
    let most = 0, dot = 0;
    for (let k = 0; k < 3; ++k) most = Math.max(most, Math.abs(actual[8 * i + k] - commanded[8 * i + k]));
    for (let k = 3; k < 7; ++k) dot += actual[8 * i + k] * commanded[8 * i + k];
    shown.push(most > 1e-3 || Math.abs(dot) < Math.cos(0.05 * Math.PI / 180));
    farthest = Math.max(farthest, most);
  }
  return {shown, farthest};
}

// Points, normals and forces of the method's contacts, and lines to what is nearest. `size`: a normal's length [m].
export function marksOf(frame, method, {distances, path, size}) {
  const marks = [];
  const thick = (from, to, width, rgb) => marks.push({from, to, width: width + 1.5, colour: rgba([0, 0, 0], 0.55)}, {from, to, width, colour: rgba(rgb)});
  if (distances && method.index === frame.methods[frame.methods.length - 1].index)
    for (const one of frame.distances.slice(0, 3)) thick(one.pointOnA, one.pointOnB, 1, colour.distance);
  for (const one of frame.contacts) {
    if (one.method !== method.index) continue;
    const tint = one.kind === contactKind.blocked ? colour.blocked : one.kind === contactKind.near ? colour.near : colour.contact;
    thick(one.point, add(one.point, scale(one.normal, size)), 1.2, tint);
    const force = length(one.force);
    if (force > 0) thick(one.point, add(one.point, scale(unit(one.force), size * Math.min(4, 0.5 + force / 200))), 2.2, colour.force);
    marks.push({from: one.point, width: one.kind === contactKind.near ? 4 : 6, colour: rgba(tint)});
  }
  if (path) for (let i = 1; i < path.length; ++i) marks.push({from: path[i - 1], to: path[i], width: 1, colour: rgba(colour.path)});
  return marks;
}

// Draws `screens` [{element, camera(poses), method, main}] of one frame.
export class Picture {
  // `pace`: how much of it is drawn (pace.js).
  constructor(renderer, pace) {
    Object.assign(this, {renderer, pace, edges: true, meshes: true, ghost: true, distances: true, path: null, turn: 0, next: 0, stale: new Set(), isMeasured: false});
  }

  setScene(scene) {
    this.scene = scene;
    this.base = coloursOf(scene.objects);
    this.renderer.setObjects(scene.objects.map(object =>
      ({solids: object.solids.map(index => scene.solids[index].vertices)})));
  }

  // Where the screens lie on the canvas, within their borders. Asked for when they were laid anew: each time would cost a layout.
  measure(screens) {
    this.isMeasured = true;
    const canvas = this.renderer.canvas.getBoundingClientRect();
    this.size = {width: canvas.width, height: canvas.height};
    for (const screen of screens) {
      const box = screen.element.getBoundingClientRect(), {clientLeft, clientTop, clientWidth, clientHeight} = screen.element;
      screen.outer = {left: box.left - canvas.left, top: box.top - canvas.top, width: box.width, height: box.height};
      screen.box = {left: screen.outer.left + clientLeft, top: screen.outer.top + clientTop, width: clientWidth, height: clientHeight};
    }
  }

  // Whether a stale screen's turn has come: once in the level's `every` pictures, or turns of the page that draw none.
  comesUp() {
    return this.stale.size > 0 && ++this.turn % this.pace.level.every === 0;
  }

  // The screens that this picture shows anew: the main ones, and of the others as many as there is time for, each in its turn. Those
  // that show less than the newest frame are `stale`, and are all that is drawn where nothing has changed.
  choose(screens, all, hasChanged) {
    const others = screens.filter(screen => !screen.main), {cctv} = this.pace.level;
    if (all || (hasChanged && cctv >= others.length)) {
      this.stale.clear();
      return screens;
    }
    if (hasChanged) for (const screen of others) this.stale.add(screen);
    const first = this.next % Math.max(1, others.length), isDue = !hasChanged || this.comesUp();
    const chosen = isDue ? [...others.slice(first), ...others.slice(0, first)].filter(screen => this.stale.has(screen)).slice(0, cctv) : [];
    if (chosen.length) this.next = others.indexOf(chosen.at(-1)) + 1;
    for (const screen of chosen) this.stale.delete(screen);
    return screens.filter(screen => (hasChanged && screen.main) || chosen.includes(screen));
  }

  // `hasChanged`: the frame does not look as what is on the screen.
  draw(frame, screens, theme, hasChanged = true) {
    const {renderer} = this;
    if (!this.isMeasured) {
      this.measure(screens);
      renderer.blank = true;
    }
    renderer.detail = this.pace.pixels;
    if (theme !== this.theme) renderer.blank = true;
    this.theme = theme;
    // Where a level has other pixels CCTV's old pictures stay until their turns: all of them at once take as long as several pictures.
    const fresh = renderer.resize(this.size, bezel[theme], screens.filter(screen => !screen.main && screen.box.width > 0).map(screen => screen.outer));
    const shown = this.choose(screens, fresh === 'blank', hasChanged || fresh === 'kept');
    for (const screen of shown)
      if (!frame.methods.some(method => method.index === screen.method)) renderer.fill(screen.outer, bezel[theme]);
    // By method, so that a method's poses are uploaded once however many cameras look at it.
    for (const method of frame.methods) this.drawMethod(frame, method, shown.filter(screen => screen.method === method.index && screen.box.width > 0));
  }

  drawMethod(frame, method, screens) {
    const {renderer, scene, theme} = this, seen = screens.filter(screen => !screen.failed), {level} = this.pace;
    if (!seen.length) return;
    // Merged objects are left out here and drawn translucent.
    const merged = mergedObjects(scene, method);
    renderer.upload(method.poses, frameColours(this.base, method), merged.size ? scene.objects.map((_, i) => !merged.has(i)) : null, this.meshes && level.meshes);
    for (const screen of seen) {
      screen.shownCamera = screen.camera(method.poses);
      renderer.fill(screen.outer, border[merged.size ? 'merged' : theme]);
      renderer.openView(screen.box, screen.shownCamera, sky[theme]);
      renderer.drawObjects({edges: this.edges && level.edges});
    }
    // Merged objects are translucent, so that one sees the one in the other.
    const reddish = this.base.map(own => rgba(mix(own, colour.merged, 0.8)));
    if (merged.size) this.drawThrough(seen, method.poses, reddish, scene.objects.map((_, i) => merged.has(i)), 0.62, false);
    this.drawCommanded(frame, method, seen);
    for (const screen of seen) {
      const size = screen.main ? 0.05 * length(subtract(screen.shownCamera.position, this.focus || [0, 0, 0])) : 0.15;
      renderer.setMarks(marksOf(frame, method, {distances: this.distances && screen.main, path: this.path, size}));
      renderer.resumeView(screen.box, screen.shownCamera);
      renderer.drawMarks();
    }
  }

  drawThrough(screens, poses, colours, shown, alpha, over) {
    const edges = this.pace.level.edges;
    this.renderer.upload(poses, colours, shown, this.meshes && this.pace.level.meshes);
    for (const screen of screens) {
      this.renderer.resumeView(screen.box, screen.shownCamera);
      this.renderer.drawObjects({alpha, over, edges});
    }
  }

  // The commanded pose, of ours. Over all: what is commanded lies inside of what stopped it. Fainter where it is close: a command is
  // mostly a few millimetres ahead, and the arm's own colours shall be seen.
  drawCommanded(frame, method, screens) {
    if (!this.ghost || method !== frame.methods[frame.methods.length - 1]) return;
    const {shown, farthest} = lagging(method.poses, frame.commanded.poses, this.scene.objects.length);
    if (!shown.some(Boolean)) return;
    const wanted = this.pace.level.edges ? screens : screens.filter(screen => screen.main);
    const alpha = 0.08 + 0.22 * Math.min(1, farthest / 0.1);
    this.drawThrough(wanted, frame.commanded.poses, this.base.map(() => rgba(colour.commanded)), shown, alpha, true);
  }

  // Draws with each program and state once, on one pixel: drivers compile at the first use, which would be in the middle of a flight.
  warmUp() {
    const {renderer} = this, corner = {left: 0, top: 0, width: 1, height: 1};
    const solid = [0, 1, 2, 3, 4, 5, 6, 7].flatMap(i => [i >> 2 & 1, i >> 1 & 1, i & 1]);
    renderer.resize({width: 8, height: 8});
    renderer.setObjects([{solids: [solid]}]);
    renderer.upload([0, 0, -3, 0, 0, 0, 1, 0], [[0, 0, 0, 1]], null);
    renderer.openView(corner, {position: [0, 0, 0], rotation: [0, 0, 0, 1], fov: 1}, [0, 0, 0]);
    for (const how of [{}, {edges: false}, {alpha: 0.5}, {alpha: 0.5, over: true}]) renderer.drawObjects(how);
    renderer.setMarks([{from: [0, 0, -2], width: 2, colour: [0, 0, 0, 1]}]);
    renderer.drawMarks();
    renderer.blank = true;
  }

  // The object under a point of a screen [CSS px in the window], or -1.
  pick(screen, x, y, poses) {
    const outer = screen.element.getBoundingClientRect(), {box} = screen, camera = screen.shownCamera;
    if (!camera) return -1;
    const left = outer.left + box.left - screen.outer.left, top = outer.top + box.top - screen.outer.top;
    const f = Math.tan(camera.fov / 2), aspect = box.width / box.height;
    const ray = [(2 * (x - left) / box.width - 1) * f * aspect, (1 - 2 * (y - top) / box.height) * f, -1];
    return this.renderer.pick(camera.position, turn(camera.rotation, ray), poses).index;
  }

  // Where p_W lies on a screen [px from the canvas's corner], or null.
  place(screen, p_W) {
    const {left, top, width, height} = screen.box || {};
    const at = screen.shownCamera && project(p_W, screen.shownCamera, width / height);
    return at && Math.abs(at[0]) < 1 && Math.abs(at[1]) < 1 ? [left + (at[0] + 1) / 2 * width, top + (1 - at[1]) / 2 * height] : null;
  }
}
