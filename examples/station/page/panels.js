// The read-outs beside the pictures. Text is written only where it changed, at most ten times a second (station.js).

import {contactKind, flag, objectFlag} from './frames.js';
import {length, subtract} from './algebra.js';

export const get = id => document.getElementById(id);

export function element(tag, fields = {}, ...children) {
  const made = Object.assign(document.createElement(tag), fields);
  made.append(...children);
  return made;
}

export function say(node, text) {
  if (node.textContent !== text) node.textContent = text;
}

// A distance in the unit that reads best.
export function metres(value) {
  const size = Math.abs(value);
  if (!Number.isFinite(value)) return '–';
  if (size >= 1) return `${value.toFixed(2)} m`;
  if (size >= 1e-4) return `${(value * 1e3).toFixed(size >= 0.01 ? 0 : 1)} mm`;
  return size >= 5e-8 ? `${(value * 1e6).toFixed(1)} µm` : '0';
}

const count = value => String(value).replace(/\B(?=(\d{3})+$)/g, '\u00a0');

// `rows`: [[left, right, class], ...]
function list(node, rows, none) {
  while (node.children.length > Math.max(1, rows.length)) node.lastChild.remove();
  while (node.children.length < Math.max(1, rows.length)) node.append(element('li', {}, element('span'), element('span')));
  (rows.length ? rows : [[none, '']]).forEach(([left, right, name = ''], i) => {
    const row = node.children[i];
    say(row.firstChild, left);
    say(row.lastChild, right);
    if (row.className !== name) row.className = name;
  });
}

// Of solid: object's name, and the solid's where the object has several.
export function nameOf(scene, solid) {
  const one = scene.solids[solid];
  if (!one) return `solid ${solid}`;
  const object = scene.objects[one.object];
  return object.solids.length > 1 && one.name ? `${object.name} / ${one.name}` : object.name;
}

// Of the two that stopped `method`: [what stands in the way, what met it], as the pilot sees it. The arm and what it carries
// come to the rest of the world, not the world to them.
export function obstacleFirst(scene, method) {
  const own = solid => {
    const index = scene.solids[solid]?.object;
    return scene.objects[index]?.kind === 'link' ? 2 : method.flags[8 * index + 7] & objectFlag.carried ? 1 : 0;
  };
  const [a, b] = method.stoppedBy;
  return own(a) < own(b) ? [a, b] : [b, a];
}

// "blocked by X", short.
export function blockedBy(scene, method) {
  if (method.stoppedBy[1] < 0) return 'blocked';
  return `blocked by ${scene.objects[scene.solids[obstacleFirst(scene, method)[0]]?.object]?.name}`;
}

// The cue of what is shown: [clear, near, contact, blocked], and how near (0 far, 1 touching).
export function cueOf(frame, method) {
  if (method.blocked) return ['blocked', 1];
  const mine = frame.contacts.filter(one => one.method === method.index);
  if (method.contact || mine.some(one => one.kind === contactKind.contact)) return ['contact', 1];
  const near = mine.filter(one => one.kind === contactKind.near);
  if (!near.length) return ['clear', 0];
  return ['near', 1 - Math.min(1, Math.min(...near.map(one => Math.max(0, one.separation))) / 0.25)];
}

export class Panels {
  constructor() {
    this.liveJoints = [];
  }

  setMethods(methods, choose) {
    this.methods = methods;
    get('methods').replaceChildren(...methods.map((method, i) => element('tr', {},
      element('td', {}, Object.assign(element('button', {type: 'button', title: method.what, onclick: () => choose(i)}, `${i + 1} ${method.name}`))),
      element('td'), element('td'), element('td'))));
  }

  // The station's flight: its choices, events and score are of this scene also while another is looked back at.
  setLive(scene) {
    this.live = scene;
    this.liveJoints = scene.arms.flatMap(arm => arm.joints);
    const options = () => this.liveJoints.map((joint, i) => element('option', {value: String(i)}, joint.name));
    get('joint').replaceChildren(...options());
    get('fault-joint').replaceChildren(...options());
    get('off-object').replaceChildren(...scene.objects.map((object, i) => [object, i]).filter(([object]) => object.selectable)
      .map(([object, i]) => element('option', {value: String(i)}, object.name)));
    get('events').replaceChildren();
  }

  // The shown frame.
  setScene(scene) {
    this.scene = scene;
    this.joints = scene.arms.flatMap(arm => arm.joints);
    for (const joint of this.joints) {  // null: no limit
      const most = joint.kind === 'prismatic' ? 1 : 2 * Math.PI;
      joint.lower ??= -most;
      joint.upper ??= most;
    }
    get('joints').replaceChildren(...this.joints.map(joint => {
      const range = element('span', {className: 'range'}, element('i', {className: 'asked'}), element('i'));
      return element('div', {role: 'row'}, element('span', {className: 'name', role: 'cell'}, joint.name),
        range, element('span', {className: 'value', role: 'cell'}));
    }));
  }

  showMethods(frame, shown, sideBySide) {
    const rows = get('methods').rows;
    this.methods.forEach((method, i) => {
      const row = rows[i], one = frame.methods.find(each => each.index === i);
      const button = row.cells[0].firstChild;
      button.setAttribute('aria-pressed', String(sideBySide ? Boolean(one) : i === shown));
      if (!one) return [1, 2, 3].forEach(k => say(row.cells[k], 'off'));
      say(row.cells[1], one.depth > 0 ? metres(one.depth) : '–');
      say(row.cells[2], one.worst > 0 ? metres(one.worst) : one.judged ? 'none' : '–');
      say(row.cells[3], one.judged ? `${count(one.merged)} of ${count(one.judged)}` : 'not judged yet');
      row.cells[1].className = one.depth > 0 ? 'bad' : '';
      row.cells[2].className = one.worst > 0 ? 'bad' : one.judged ? 'good' : '';
    });
    const isForced = frame.flags & flag.dynamics && shown === this.methods.length - 1;
    const what = isForced ? 'joints of limited torque and contact forces, what is shown proven' : this.methods[shown].what;
    say(get('method-what'), `${this.methods[shown].name}: ${what}. Merged, of what is checked: by exact arithmetic, from the poses shown.`);
  }

  showContact(frame, method) {
    const scene = this.scene, stopped = method.blocked && method.stoppedBy[1] >= 0, [obstacle, own] = obstacleFirst(scene, method);
    say(get('blocked'), stopped ? `Blocked by ${nameOf(scene, obstacle)} (met by ${nameOf(scene, own)})` : method.blocked ? 'Blocked' :
      method.slid ? 'Slides along what it touches' : frame.flags & flag.brakes ? 'Brakes are on' :
        frame.flags & flag.atLimit ? 'At a joint\'s limit' : frame.flags & flag.singular ? 'Near a singularity' : '');
    this.showForces(frame);
    list(get('distances'), frame.distances.slice(0, 6).map(one => [nameOf(scene, one.b), metres(one.separation), one.separation <= 1e-6 ? 'now' : '']), 'nothing within 2 m');
    const kinds = ['', 'near', 'blocks'];
    const mine = frame.contacts.filter(one => one.method === method.index);
    mine.sort((one, other) => length(other.force) - length(one.force));
    list(get('contacts'), mine.slice(0, 8).map(one => {
      const force = length(one.force);
      return [`${nameOf(scene, one.a)} – ${nameOf(scene, one.b)} ${kinds[one.kind]}`,
        force > 0 ? `${force.toFixed(0)} N` : metres(one.separation), one.kind === contactKind.near ? '' : 'now'];
    }).concat(mine.length > 8 ? [[`and ${mine.length - 8} more`, '']] : []), 'none');
  }

  // Of ours: what presses on the arm and what it carries, and how much of its limit the most loaded joint gives.
  showForces(frame) {
    get('forces').hidden = !(frame.flags & flag.dynamics);
    if (get('forces').hidden) return;
    const own = solid => {
      const index = this.scene.solids[solid]?.object;
      return this.scene.objects[index]?.kind === 'link' || Boolean(frame.methods.at(-1).flags[8 * index + 7] & objectFlag.carried);
    };
    const force = frame.contacts.filter(one => own(one.a) !== own(one.b)).reduce((sum, one) => sum + length(one.force), 0);
    say(get('force'), `${force.toFixed(0)} N`);
    const share = Math.max(0, ...frame.joints.map((joint, i) => this.joints[i]?.effort ? Math.abs(joint.torque) / this.joints[i].effort : 0));
    say(get('torque'), `${(100 * share).toFixed(0)} %`);
    get('torque').parentNode.classList.toggle('bad', share > 0.99);
  }

  showJoints(frame, chosen, jointMode) {
    const rows = get('joints').children;
    frame.joints.forEach((joint, i) => {
      const row = rows[i], described = this.joints[i];
      if (!row) return;
      const part = value => `${(100 * Math.max(0, Math.min(1, (value - described.lower) / (described.upper - described.lower)))).toFixed(1)}%`;
      row.children[1].firstChild.style.left = part(joint.commanded);
      row.children[1].lastChild.style.left = part(joint.actual);
      row.className = jointMode && i === chosen ? 'chosen' : '';
      const torque = frame.flags & flag.dynamics && described.effort ? ` ${(100 * Math.abs(joint.torque) / described.effort).toFixed(0)} %` : '';
      const value = described.kind === 'prismatic' ? metres(joint.actual) : `${(joint.actual * 180 / Math.PI).toFixed(1)}°`;
      say(row.children[2], `${value}${torque}`);
    });
  }

  showScore(score) {
    list(get('task-list'), (score.tasks || []).map(task => {
      const described = (this.live.tasks || []).find(one => one.name === task.name);
      const limits = Object.entries(described?.limits || {}).map(([name, most]) => `${most} ${{force: 'N', time: 's', contacts: 'contacts'}[name]}`).join(', ');
      const over = task.done && task.within_limits === false;
      return [`${described?.title || task.name}${limits ? ` (at most ${limits})` : ''}`,
        task.done ? `done, ${task.elapsed.toFixed(1)} s${over ? ', over its limits' : ''}` : 'open', task.done && !over ? 'done' : ''];
    }), 'fly freely');
    // A debrief has the path's points in place of its length.
    const path = Array.isArray(score.path) ? score.path.slice(1).reduce((sum, point, i) => sum + length(subtract(point.slice(1, 4), score.path[i].slice(1, 4))), 0) : score.path;
    say(get('score'), `${(score.elapsed ?? 0).toFixed(0)} s, ${score.contacts ?? 0} contact${score.contacts === 1 ? '' : 's'}, cues for ${(score.cue_seconds ?? 0).toFixed(1)} s, ` +
      // null: this station knows no forces.
      `${score.largest_force === null ? '' : `largest force ${(score.largest_force ?? 0).toFixed(0)} N, `}path ${(path ?? 0).toFixed(2)} m`);
  }

  // Keeps the newest hundred; what comes again while it is among the newest eight is counted there. That a contact of two
  // facets ended says little: a slide along a tube's facets makes and ends many.
  addEvent(event) {
    if (event.kind === 'ended') return;
    const objectOf = solid => this.live.objects[this.live.solids[solid]?.object]?.name;
    const pair = event.a >= 0 && event.b >= 0 ? `${objectOf(event.a)} – ${objectOf(event.b)}` : '';
    const text = `${event.kind.replace(/_/g, ' ')} ${event.text && event.text !== event.kind ? event.text : pair}`.trim(), seconds = event.time === undefined ? '' : `${event.time.toFixed(2)} s`;
    const log = get('events'), again = [...log.children].slice(0, 8).find(row => row.dataset.text === text);
    if (again) {
      again.dataset.count = String(Number(again.dataset.count) + 1);
      say(again.firstChild, `${text} ×${again.dataset.count}`);
      return say(again.lastChild, seconds);
    }
    const row = element('li', {}, element('span', {}, text), element('span', {}, seconds));
    Object.assign(row.dataset, {text, count: '1'});
    log.prepend(row);
    while (log.children.length > 100) log.lastChild.remove();
  }

  showDebrief(debrief) {
    say(get('debrief-text'), '');
    this.showScore(debrief);
    get('debrief-text').append(...[...get('task-list').children].map(row => element('p', {}, [...row.children].map(part => part.textContent).filter(Boolean).join(': '))), element('p', {}, get('score').textContent));
    const path = debrief.path || [];
    const project = (k, l, left) => {
      const low = i => Math.min(...path.map(p => p[i])), span = Math.max(1e-6, ...[k, l].map(i => Math.max(...path.map(p => p[i])) - low(i)));
      return path.map(p => `${(left + 10 + 170 * (p[k] - low(k)) / span).toFixed(1)},${(190 - 170 * (p[l] - low(l)) / span).toFixed(1)}`).join(' ');
    };
    const svg = get('debrief-path');
    svg.setAttribute('viewBox', '0 0 400 200');
    svg.innerHTML = path.length < 2 ? '<text x="10" y="20">no path yet</text>' :
      `<polyline points="${project(1, 2, 0)}"/><polyline points="${project(1, 3, 200)}"/><text x="10" y="14">from above</text><text x="210" y="14">from the side</text>`;
    list(get('debrief-events'), (debrief.events || []).slice(-200).map(event =>
      [`${(event.kind || '').replace(/_/g, ' ')} ${event.text || (event.a >= 0 ? `${nameOf(this.live, event.a)} – ${nameOf(this.live, event.b)}` : '')}`, event.time === undefined ? '' : `${event.time.toFixed(2)} s`]), 'no events');
  }

  showLatency(latency, stages) {
    const at = share => { const value = latency.percentile(share); return Number.isNaN(value) ? '–' : `${value.toFixed(value < 10 ? 1 : 0)} ms`; };
    say(get('p999'), at(0.999));
    say(get('median'), at(0.5));
    say(get('over'), `${latency.late} of ${latency.total}`);
    latency.draw(get('histogram'));
    if (!stages) return;
    const names = {input_to_received: 'to the station', received_to_started: 'waits for the step', started_to_decided: 'decided',
      decided_to_sent: 'to the socket', sent_to_drawn: 'sent and drawn', input_to_drawn: 'sum'};
    get('stages').replaceChildren(element('tr', {}, ...['stage', 'median', '99.9 %', 'worst'].map(text => element('th', {scope: 'col'}, text))),
      ...Object.entries(names).filter(([key]) => stages[key] && stages[key].median !== undefined).map(([key, text]) => element('tr', {}, element('td', {}, text),
        ...['median', 'p999', 'worst'].map(which => element('td', {}, `${(stages[key][which] / 1000).toFixed(2)} ms`)))));
  }
}
