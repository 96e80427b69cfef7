// The one connection to the station: it keeps the newest frame only, measures the clocks' offset (clock.js), and connects again by
// itself when the station went away.

import {readFrame} from './frames.js';
import {Clock} from './clock.js';

const now = () => performance.now() * 1000;  // browser's clock [us]

export class Link extends EventTarget {
  // `address`: of the WebSocket. Events: `text` (detail: the message), `connection` (detail: true, false). `onFrame`, where there is one, is
  // called when a frame was taken.
  constructor(address) {
    super();
    Object.assign(this, {address, newest: null, underWay: 0, onFrame: null, undrawn: 0, unread: 0, offset: 0, rtt: Infinity, number: 0, wait: 250, client: 0});
    this.clock = new Clock();
    this.connect();
    this.pingOn();
  }

  connect() {
    let socket;
    try {
      socket = new WebSocket(this.address, 'touchstone-station-1');
    } catch (fault) {
      return this.again();
    }
    this.socket = socket;
    socket.binaryType = 'arraybuffer';
    socket.onopen = () => {
      Object.assign(this, {wait: 250, newest: null, rtt: Infinity});
      this.clock.forget();
      this.dispatchEvent(new CustomEvent('connection', {detail: true}));
      this.ping();
    };
    socket.onmessage = ({data}) => typeof data === 'string' ? this.takeText(data) : this.takeFrame(data);
    socket.onclose = () => {
      if (this.socket !== socket) return;
      this.dispatchEvent(new CustomEvent('connection', {detail: false}));
      this.again();
    };
  }

  // Tries again after a quarter of a second, then twice as long each time, up to four seconds.
  again() {
    setTimeout(() => this.connect(), this.wait);
    this.wait = Math.min(4000, this.wait * 2);
  }

  takeText(data) {
    const message = JSON.parse(data);
    if (message.type === 'hello') this.client = message.client;
    if (message.type === 'pong') this.takePong(message);
    this.dispatchEvent(new CustomEvent('text', {detail: message}));
  }

  takeFrame(data) {
    if (data.byteLength >= 128) this.noteTimes(new DataView(data));
    if (data.byteLength >= 16) this.send({type: 'seen', frame: Number(new DataView(data).getBigUint64(8, true))});
    if (this.newest) ++this.undrawn;  // it will never be shown: the newer one wins
    this.newest = data;
    this.onFrame?.();
  }

  // The newest frame if it has not been taken yet, else null. Only what is shown is read.
  take() {
    if (!this.newest) return null;
    const frame = readFrame(this.newest);
    if (!frame) ++this.unread;
    this.newest = null;
    return frame;
  }

  ping() {
    this.send({type: 'ping', stamp: now()});
  }

  pingOn() {
    this.ping();
    setTimeout(() => this.pingOn(), this.clock.untilPing);
  }

  takePong({stamp, received_us, sent_us}) {
    const arrived = now();
    this.clock.there(arrived, stamp, received_us);
    this.clock.here(arrived, sent_us);
    Object.assign(this, this.clock.known);
  }

  // A frame says when it was sent, and when a hand of this page was received. `underWay`: of the newest, from sent to taken [ms].
  noteTimes(frame) {
    const arrived = now();
    this.clock.here(arrived, frame.getFloat64(56, true));
    this.underWay = (arrived + this.offset - frame.getFloat64(56, true)) / 1000;
    if (frame.getUint32(64, true) === this.client) this.clock.there(arrived, frame.getFloat64(24, true), frame.getFloat64(32, true));
    Object.assign(this, this.clock.known);
  }

  get open() {
    return this.socket && this.socket.readyState === WebSocket.OPEN;
  }

  // Nothing queues up in a stalled socket either.
  send(message) {
    if (this.open && this.socket.bufferedAmount < 65536) this.socket.send(JSON.stringify(message));
  }

  control(fields) {
    this.send({type: 'control', ...fields});
  }

  input({translation, rotation, joint, grip}) {
    this.send({type: 'input', number: ++this.number, stamp: now(), translation, rotation, joint, grip});
  }

  drawn(frame, stamp) {
    this.send({type: 'drawn', frame, stamp, offset: this.offset, rtt: this.rtt === Infinity ? 0 : this.rtt});
  }

  // Age of what `frame` shows [us], from the moment its poses were known.
  age(frame) {
    return now() + this.offset - frame.decided;
  }
}
