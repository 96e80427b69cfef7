// A made-up station in the page itself, for tests: stands in for WebSocket and speaks protocol.md. A tip flies along x
// towards a wall at x = 1; `no check` goes through, `figure 1` stops 100 ms late, `figure 2` and `ours` stop at it.
// `fake.solids`: that many boxes move besides; `fake.tips`: ends that the hand may fly; `fake.mute`: no contact is told of; `fake.late`: answers to pings come so many ms late; `fake.rate`: frames a second; `fake.choose(name)`: another scene, of the next serial.
(() => {
'use strict';
const fake = window.fake = {solids: 0, rate: 50, received: [], sockets: [], down: false, dead: false, wall: 1, serial: 1, name: 'made_up', ...(window.fakeOptions || {})};
const box = (x, y, z) => [...Array(8).keys()].flatMap(i => [(i >> 2 & 1 ? x : -x) / 2, (i >> 1 & 1 ? y : -y) / 2, (i & 1 ? z : -z) / 2]);
const shapes = [['arm.boom', 'link', [2, 0.2, 0.2]], ['arm.tip_lee', 'link', [0.4, 0.3, 0.3]], ['wall', 'static', [0.3, 2, 2]], ['block', 'free', [0.4, 0.4, 0.4]]];
const half = 0.2, gap = 1e-9;

function scene() {
  const all = [...shapes, ...Array.from({length: fake.solids}, (_, i) => [`mote ${i}`, 'free', [0.12, 0.12, 0.12]])];
  return {type: 'scene', name: fake.name, title: 'Made up', description: '', serial: fake.serial, gap,
    objects: all.map(([name, kind], i) => ({name, kind, selectable: kind !== 'link', moves: kind !== 'static', solids: [i]})),
    solids: all.map(([name, , size], i) => ({object: i, name, vertices: box(...size)})),
    arms: [{name: 'arm', links: [0, 1], hand: 1, tip: {object: 1, position: [half, 0, 0], rotation: [0, 0, 0, 1]}, base: {position: [0, 0, 0], rotation: [0, 0, 0, 1]},
      joints: [{name: 'shoulder', lower: -3, upper: 3, rate: 0.1, effort: 100}, {name: 'elbow', lower: -3, upper: 3, rate: 0.1, effort: 100}]}],
    cameras: [{name: 'wrist', object: 1, position: [0, 0, 0.35], look: [1, 0, -0.2], up: [0, 0, 1], fov: 0.9},
      {name: 'elbow', object: 0, position: [-0.8, 0, 0.7], look: [1, 0, -0.3], up: [0, 0, 1], fov: 0.8},
      {name: 'bay', object: -1, position: [0.2, -3.5, 0.6], look: [0.1, 1, -0.1], up: [0, 0, 1], fov: 0.7},
      {name: 'pan-tilt', object: -1, position: [-1.5, 2.5, 1.4], look: [1, -1, -0.5], up: [0, 0, 1], fov: 0.8}],
    tasks: [{name: 'touch', title: 'Touch the wall'}], latches: [], rates: {coarse: {translation: 0.37, rotation: 0.0698}, vernier: {translation: 0.02, rotation: 0.0105}, joint: 0.0698, slide: 0.0698}, ...(fake.tips ? {tips: fake.tips} : {})};
}

// `lost`: its text does not arrive.
fake.choose = (name, lost = false) => {
  Object.assign(fake, {name, serial: fake.serial + 1});
  if (!lost) fake.sockets.at(-1).text(scene());
};

class FakeSocket extends EventTarget {
  constructor(url, protocol) {
    super();
    Object.assign(this, {url, protocol, readyState: 0, bufferedAmount: 0, frame: 0, x: [-1, -1, -1, -1], commanded: -1, worst: [0, 0, 0, 0], merged: [0, 0, 0, 0],
      history: [], input: {translation: [0, 0, 0], rotation: [0, 0, 0], stamp: NaN, number: 0},
      state: {mode: 'hand', frame_of_command: 'end effector', vernier: false, brakes: false, joint: 0, scene: 'made_up', dynamics: false, methods: [0, 1, 2, 3], selected_off: [], latched: [], faults: [], pilot: 1}});
    fake.sockets.push(this);
    setTimeout(() => this.open(), 5);
  }
  open() {
    if (fake.down) return this.close();
    this.readyState = 1;
    this.onopen?.({});
    const methods = [['no check', 'every command is carried out'], ['figure 1', 'the image generator reports contacts 100 ms late'], ['figure 2', 'the first build'], ['ours', 'contact world']];
    this.text({type: 'hello', version: 2, client: 1, rate_hz: fake.rate, station_us: this.clock(), scenes: [{name: 'made_up', title: 'Made up'}, {name: 'other', title: 'Other'}], scene: fake.name,
      methods: methods.map(([name, what]) => ({name, what})), limits: {late_us: 150000}});
    this.text(scene());
    this.text({type: 'state', frame: 0, ...this.state});
    this.text({type: 'score', frame: 0, tasks: [{name: 'touch', done: false, elapsed: 0}], elapsed: 1, contacts: 0, cue_seconds: 0, largest_force: 0, path: 0});
    this.timer = setInterval(() => { if (!fake.dead) this.step(); }, 1000 / fake.rate);
  }
  clock() { return performance.now() * 1000 + 5e6; }
  text(message) { this.onmessage?.({data: JSON.stringify(message)}); }
  close() {
    clearInterval(this.timer);
    this.readyState = 3;
    setTimeout(() => this.onclose?.({}), 0);
  }
  send(data) {
    const message = JSON.parse(data);
    fake.received.push(message);
    if (fake.received.length > 2000) fake.received.shift();
    if (message.type === 'input') { this.input = message; this.receivedAt = this.clock(); }
    if (message.type === 'ping') {
      const pong = {type: 'pong', stamp: message.stamp, received_us: this.clock(), sent_us: this.clock()};
      if (fake.late) setTimeout(() => this.text(pong), fake.late);
      else this.text(pong);
    }
    if (message.type === 'control') {
      const {type, reset, latch, release, fault, select, debrief, ...fields} = message;
      Object.assign(this.state, fields);
      if (fault) this.state.faults = [fault];
      if (select) this.state.selected_off = select.on ? [] : [select.object];
      if (reset) Object.assign(this, {x: [-1, -1, -1, -1], commanded: -1, worst: [0, 0, 0, 0], merged: [0, 0, 0, 0], history: []});
      this.text({type: 'state', frame: this.frame, ...this.state});
      if (debrief) this.text({type: 'debrief', tasks: [{name: 'touch', done: true, elapsed: 3}], elapsed: 9, contacts: 1, cue_seconds: 1, largest_force: 12, path: [[0, -1, 0, 0], [1, 0, 0.2, 0.1], [2, 1, 0, 0]], events: [{kind: 'began', a: 1, b: 2, time: 1.5}]});
    }
  }
  step() {
    const begun = this.clock(), rate = this.state.brakes ? 0 : this.input.translation[0] * (this.state.vernier ? 0.1 : 2) / fake.rate;
    const limit = fake.wall - 0.15 - half;
    this.commanded = Math.min(this.x[3] + 0.25, Math.max(this.x[3] - 0.25, this.commanded + rate));
    if (!rate) this.commanded = this.x[3];
    this.x[0] += rate;
    this.history.push(this.x[1] > limit);
    const reported = this.history[this.history.length - 1 - Math.round(0.1 * fake.rate)];
    if (!(reported && rate > 0)) this.x[1] += rate;
    for (const i of [2, 3]) this.x[i] = Math.min(limit, this.x[i] + rate);
    ++this.frame;
    this.x.forEach((x, i) => {
      const depth = Math.max(0, x - limit);
      if (depth > 0) ++this.merged[i];
      this.worst[i] = Math.max(this.worst[i], depth);
    });
    const blocked = rate > 0 && this.x[3] >= limit;
    if (blocked && !this.wasBlocked) this.text({type: 'event', frame: this.frame, time: this.frame / fake.rate, kind: 'blocked', a: 1, b: 2});
    this.wasBlocked = blocked;
    this.onmessage?.({data: this.encode(begun, limit, blocked)});
  }
  encode(begun, limit, blocked) {
    const n = shapes.length + fake.solids, near = !fake.mute && limit - this.x[3] < 0.25 ? 1 : 0;
    const bytes = 128 + 4 * 64 + 5 * 32 * n + 2 * 16 + near * 64 + (fake.far ? 0 : 2 * 48), view = new DataView(new ArrayBuffer(bytes));
    const f32 = (at, ...values) => values.forEach((value, i) => view.setFloat32(at + 4 * i, value, true));
    view.setUint32(0, 0x31465354, true); view.setUint16(4, 1, true); view.setUint16(6, 128, true);
    view.setBigUint64(8, BigInt(this.frame), true);
    [this.frame / fake.rate, this.input.stamp, this.receivedAt ?? NaN, begun, this.clock(), this.clock()].forEach((value, i) => view.setFloat64(16 + 8 * i, value, true));
    view.setUint32(64, 1, true); view.setUint32(68, this.input.number, true); view.setUint32(72, n, true);
    view.setUint16(76, 4, true); view.setUint16(78, 2, true); view.setUint32(80, near, true); view.setUint32(84, fake.far ? 0 : 2, true);
    const touching = this.x[3] >= limit;
    view.setUint32(104, (this.state.brakes ? 1 : 0) | (this.state.vernier ? 2 : 0) | (blocked ? 256 : 0) | (touching ? 512 : 0), true);
    view.setUint32(108, bytes, true); view.setUint32(112, fake.serial, true);
    let at = 128;
    this.x.forEach((x, i) => {
      const depth = Math.max(0, x - limit), stopped = i === 3 && blocked;
      view.setUint16(at, i, true); view.setUint16(at + 2, (stopped ? 1 : 0) | (i === 3 && touching ? 2 : 0), true);
      view.setUint32(at + 4, this.merged[i], true); view.setFloat64(at + 8, depth, true); view.setFloat64(at + 16, this.worst[i], true);
      view.setBigUint64(at + 24, BigInt(this.frame), true); view.setUint32(at + 32, this.frame, true);
      view.setInt32(at + 40, stopped ? 1 : -1, true); view.setInt32(at + 44, stopped ? 2 : -1, true);
      view.setInt32(at + 56, depth > 0 ? 1 : -1, true); view.setInt32(at + 60, depth > 0 ? 2 : -1, true);
      at += 64;
    });
    for (const [i, x] of [...this.x, this.commanded].entries()) {
      const place = (p, flags = 0, q = [0, 0, 0, 1]) => { f32(at, ...p, ...q); view.setUint32(at + 28, flags, true); at += 32; };
      place([x - half - 1, 0, 0]);
      place([x, 0, 0], i === 3 && touching ? 1 : 0);
      place([fake.wall, 0, 0], i === 3 && touching ? 1 : 0);
      place([0, -0.9, -0.5]);
      for (let k = 0; k < fake.solids; ++k) {
        const angle = k * 2.4 + this.frame * 0.02, radius = 0.8 + 0.05 * Math.sqrt(k);
        place([radius * Math.cos(angle), radius * Math.sin(angle), 0.6 + 0.003 * k], 0, [0, 0, Math.sin(angle), Math.cos(angle)]);
      }
    }
    f32(at, this.x[3], this.commanded, 0.1, 40); f32(at + 16, 0.5, 0.5, 0, 0);
    at += 32;
    if (near) {
      view.setUint16(at, 3, true); view.setUint16(at + 2, blocked ? 2 : touching ? 0 : 1, true); view.setUint32(at + 4, 1, true); view.setUint32(at + 8, 2, true);
      f32(at + 12, limit - this.x[3], this.x[3] + half, 0, 0, 1, 0, 0, blocked ? 120 : 0, 0, 0);
      at += 64;
    }
    for (const [b, point, separation] of fake.far ? [] : [[2, [fake.wall - 0.15, 0, 0], limit - this.x[3]], [3, [0, -0.7, -0.5], 0.8]]) {
      view.setUint32(at, 1, true); view.setUint32(at + 4, b, true); view.setFloat64(at + 8, separation, true);
      f32(at + 16, this.x[3] + half, 0, 0, ...point);
      at += 48;
    }
    return view.buffer;
  }
}
Object.assign(FakeSocket, {CONNECTING: 0, OPEN: 1, CLOSING: 2, CLOSED: 3});
window.WebSocket = FakeSocket;
})();
